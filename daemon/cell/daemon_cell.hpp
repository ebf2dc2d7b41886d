#pragma once

#include "daemon/cell/backup_service.hpp"
#include "daemon/cell/campaign_service.hpp"
#include "daemon/cell/identification_service.hpp"
#include "daemon/cell/recording_service.hpp"
#include "daemon/cell/report_service.hpp"
#include "daemon/cell/stream_service.hpp"
#include "daemon/cell/target_service.hpp"
#include "daemon/cell/tool_service.hpp"
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
      std::string method, boost::json::object params, std::string by) override;
  MethodReply pause(std::string why, std::string by) override;
  std::string doing() const override { return runner_.reason(); }
  void unrecorded(const std::string& why) override { store_.failed({why, true}); }
  void stand(bool stands, const Fault& fault) override { runner_.faults().stand(stands, fault); }

  boost::asio::awaitable<StoreResult<void>> load_tools() { return tools_.load(); }
  /// After load_tools().
  boost::asio::awaitable<StoreResult<void>> load_active_model() { return models_.load_active(); }
  boost::asio::awaitable<StoreResult<void>> load_interrupted_campaigns() {
    return campaigns_.load_interrupted();
  }
  /// After load_active_model().
  boost::asio::awaitable<void> arm_as_before() { return stream_.arm_as_before(); }
  /// What of the cell is measured over time.
  struct Snapshot {
    std::string_view state;                ///< its name on the wire
    std::size_t warnings = 0, errors = 0;  ///< faults that stand
    bool robot_connected = false, robot_ready = false, tracker_connected = false;
    bool armed = false;
    std::optional<CampaignProgress> campaign{};  ///< of the one under way
    std::optional<ModelRecord> model{};          ///< the active one
  };
  Snapshot snapshot() const;

  /// Watches devices, stream and the states that have to pass by themselves. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  /// The store takes no events.
  void store_failed(const StoreError& error) { store_.failed(error); }
  /// Ramps the correction out, interrupts a campaign and writes that, lets the devices go.
  boost::asio::awaitable<void> shut_down();

 private:
  rpc::CellStatus status() const;

  Parts parts_;
  CellRunner runner_;
  StoreWatch store_;
  DeviceService devices_;
  ToolService tools_;
  ModelService models_;
  TargetService targets_;
  StreamService stream_;
  RecordingService recording_;
  CampaignService campaigns_;
  CampaignArchive archive_;
  ReportService reports_;
  IdentificationService identifications_;
  BackupService backups_;
  MethodTable table_;
};

}  // namespace truepose::daemon
