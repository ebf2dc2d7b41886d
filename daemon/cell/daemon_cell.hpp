#pragma once

#include "daemon/cell/campaign_service.hpp"
#include "daemon/cell/recording_service.hpp"
#include "daemon/cell/stream_service.hpp"
#include "daemon/cell/target_service.hpp"
#include "daemon/control/control_server.hpp"

namespace truepose::daemon {

/// The cell as the control protocol sees it: its services, run by one state machine. Everything but the
/// workers' jobs runs on one thread.
class DaemonCell final : public CellService {
 public:
  using Parts = CellParts;
  explicit DaemonCell(Parts parts);

  static std::vector<std::string> method_names();
  std::vector<std::string> methods() const override { return method_names(); }
  boost::asio::awaitable<std::expected<boost::json::value, control::RpcError>> call(
      std::string method, boost::json::object params) override;

  boost::asio::awaitable<StoreResult<void>> load_active_model() { return models_.load_active(); }
  boost::asio::awaitable<StoreResult<void>> load_interrupted_campaigns() {
    return campaigns_.load_interrupted();
  }
  /// After load_active_model().
  boost::asio::awaitable<void> arm_as_before() { return stream_.arm_as_before(); }
  /// Watches devices, stream and the states that have to pass by themselves. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  /// Ramps the correction out, interrupts a campaign and writes that, lets the devices go.
  boost::asio::awaitable<void> shut_down();

 private:
  boost::json::object status_json() const;

  Parts parts_;
  CellRunner runner_;
  DeviceService devices_;
  ModelService models_;
  TargetService targets_;
  StreamService stream_;
  RecordingService recording_;
  CampaignService campaigns_;
  CampaignArchive archive_;
  MethodTable table_;
};

}  // namespace truepose::daemon
