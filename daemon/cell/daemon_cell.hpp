#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/store_journal.hpp"
#include "daemon/campaign/stored_model.hpp"
#include "daemon/cell/cell_json.hpp"
#include "daemon/cell/cell_state.hpp"
#include "daemon/cell/stream_trouble.hpp"
#include "daemon/control/cell_service.hpp"
#include "daemon/control/event_bus.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "daemon/realtime/stream_log.hpp"
#include "daemon/store/store.hpp"
#include "daemon/worker.hpp"

namespace truepose::daemon {

/// The cell as the control protocol sees it: carries out what the state machine commands, and tells it how
/// that went. Everything but the workers' jobs runs on one thread.
class DaemonCell final : public CellService, private CampaignObserver {
 public:
  /// All of it outlives the cell.
  struct Parts {
    boost::asio::any_io_executor io;
    const config::CellConfig& config;
    drivers::Robot& robot;
    drivers::Tracker& tracker;
    drivers::Clock& clock;
    StreamCycle& stream;
    Store& store;  ///< touched by the store thread alone
    Worker& store_thread;
    Worker& compute_thread;
    EventBus& events;
    StoreJournal::WallClock wall_clock;
  };
  explicit DaemonCell(Parts parts);
  ~DaemonCell() override;

  static std::vector<std::string> method_names();
  std::vector<std::string> methods() const override { return method_names(); }
  boost::asio::awaitable<std::expected<boost::json::value, control::RpcError>> call(
      std::string method, boost::json::object params) override;

  /// Takes the active model from the store. One that is no longer what was made is not worked with, and is a
  /// fault until another is activated.
  boost::asio::awaitable<StoreResult<void>> load_active_model();
  /// Watches devices, stream and the states that have to pass by themselves. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  /// Ramps the correction out, ends a campaign and writes its end, lets the devices go.
  boost::asio::awaitable<void> shut_down();

  std::string_view state() const { return state_name(state_); }

 private:
  using Result = std::expected<boost::json::value, control::RpcError>;
  using Reply = boost::asio::awaitable<Result>;
  using Handler = Reply (DaemonCell::*)(boost::json::object);
  struct Method {
    const char* name;
    Handler handler;
  };
  static const std::vector<Method>& table();

  struct Active {
    ModelRecord record;
    CalibratedCell cell;
    std::optional<DriftReference> drift_reference;
  };
  struct CampaignRun;
  /// A model as the store has it, and whether it still is the one that was made.
  struct FoundModel {
    ModelRecord record;
    std::expected<StoredModel, std::string> checked;
  };

  Reply system_config(boost::json::object params);
  Reply cell_status(boost::json::object params);
  Reply cell_connect(boost::json::object params);
  Reply cell_disconnect(boost::json::object params);
  Reply cell_acknowledge(boost::json::object params);
  Reply campaign_start(boost::json::object params);
  Reply drift_check(boost::json::object params);
  Reply campaign_pause(boost::json::object params);
  Reply campaign_resume(boost::json::object params);
  Reply campaign_abort(boost::json::object params);
  Reply campaign_list(boost::json::object params);
  Reply campaign_get(boost::json::object params);
  Reply report_get(boost::json::object params);
  Reply model_list(boost::json::object params);
  Reply model_get(boost::json::object params);
  Reply model_activate(boost::json::object params);
  Reply model_deactivate(boost::json::object params);
  Reply model_export(boost::json::object params);
  Reply targets_compensate(boost::json::object params);
  Reply stream_start(boost::json::object params);
  Reply stream_stop(boost::json::object params);
  Reply stream_status(boost::json::object params);

  /// Feeds one event to the state machine and carries out what needs no waiting.
  /// @return the refusal as an error, where there was one
  std::optional<control::RpcError> apply(const CellEvent& event, const std::string& reason);
  Result simple_request(const boost::json::object& params, const CellEvent& event, const std::string& reason);
  Reply start_calibration(boost::json::object params);
  Reply start_targets(boost::json::object params);
  Reply start_iso9283(boost::json::object params);
  /// Why the active model cannot be worked with; nothing where it can.
  std::string model_trouble() const;
  Result needs_model(const std::string& why_not) const;
  Result start_campaign(const config::CellConfig& config, CampaignOrder order, bool activate = false);
  boost::asio::awaitable<void> run_campaign();
  boost::asio::awaitable<std::expected<ModelRecord, control::RpcError>> find_model(std::string id);
  /// @param id  empty: the active one
  boost::asio::awaitable<StoreResult<std::optional<FoundModel>>> find_checked(std::string id);
  control::RpcError refused_model(const std::string& why_not) const;
  /// @param sentence  why the active model is not worked with; empty: it is, or there is none
  void judge_active_model(const std::string& sentence);
  boost::asio::awaitable<void> watch_cell();
  boost::asio::awaitable<void> watch_devices();
  boost::asio::awaitable<void> watch_robot();
  boost::asio::awaitable<void> watch_tracker();
  boost::asio::awaitable<void> devices_unasked();
  bool devices_may_be_asked() const;
  void watch_stream();
  void watch_silence(std::optional<Duration> lasts);
  void stand(std::optional<Fault>& standing, bool stands, Fault fault);
  static std::optional<Duration> packet_age(const StreamStatus& status, TimePoint now);

  void on_progress(const CampaignProgress& progress) override;
  void on_point(const StoredPoint& point, double deviation_mm, const CampaignProgress& progress) override;
  void on_skipped(const SkippedPose& skipped, const CampaignProgress& progress) override;
  void on_trouble(const std::string& sentence) override;
  void on_paused(const std::string& sentence) override { apply(CampaignPaused{}, sentence); }

  boost::json::object status_json() const;
  boost::json::object progress_json() const;
  boost::json::object stream_now_json() const;
  std::string no_answer(const StreamStatus& now) const;
  std::string stream_trouble(const StreamStatus& now) const;
  void publish_fault(const Fault& fault, bool standing);
  void publish_model(const char* change, const ModelRecord& record);
  bool streaming() const;

  Parts parts_;
  CellDevices devices_;
  CellState state_ = Disconnected{};
  std::string state_reason_ = "started";
  std::string state_since_;
  std::optional<Identities> identities_;
  std::optional<drivers::RobotState> robot_state_;
  bool devices_asked_ = false;             ///< a question of watch_devices() is under way
  std::unique_ptr<CampaignRun> campaign_;  ///< the last one, running or ended
  std::optional<Active> active_;
  std::uint64_t model_number_ = 0;
  StreamState stream_state_ = StreamState::Idle;
  StreamLog stream_log_{[](LogLevel level, const std::string& line) { log(level, line); }};
  StreamStatus before_request_;    ///< when the stream was asked for last
  StreamStatus before_stream_;     ///< when its program ran
  bool stream_broke_off_ = false;  ///< the fault, where there is one, ended a stream
  RefusedPackets refused_;
  std::optional<Fault> model_fault_;   ///< stands while the store's active model is refused
  std::optional<Fault> frozen_;        ///< stands while the stream waits for an arm that does not follow
  std::optional<Fault> unproven_;      ///< stands while packets come and none can be answered
  TimePoint proven_{};                 ///< when that was not so
  std::optional<Fault> tracker_lost_;  ///< stands while a stream runs without its tracker
  std::optional<Fault> silent_;  ///< stands while a stream that goes on by itself waits for its controller
};

}  // namespace truepose::daemon
