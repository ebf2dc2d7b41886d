#pragma once

#include <boost/asio/awaitable.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/cell/controller_signals.hpp"
#include "daemon/cell/last_minute.hpp"
#include "daemon/cell/model_service.hpp"
#include "daemon/cell/stream_report.hpp"
#include "daemon/realtime/stream_status.hpp"

namespace truepose::daemon {

/// The stream of corrections as an operator has it: starts and stops it, and watches what comes of it.
class StreamService {
 public:
  StreamService(const CellParts& parts, CellRunner& runner, StoreWatch& store, DeviceService& devices,
                ModelService& models);

  static std::vector<Served<StreamService>> methods();

  /// Arms the stream where it was armed when the daemon ended.
  boost::asio::awaitable<void> arm_as_before();
  /// Looks after the stream. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  /// Whether a correction is being ramped out, or would be if it were asked for.
  bool in_effect() const;
  rpc::StreamStatus status() const;

 private:
  Reply<rpc::StreamStart> start(rpc::StreamStart, std::string by);
  Reply<rpc::StreamStop> stop(rpc::StreamStop, std::string by);
  Reply<rpc::StreamArm> arm(rpc::StreamArm, std::string by);
  Reply<rpc::StreamDisarm> disarm(rpc::StreamDisarm, std::string by);
  Reply<rpc::GetStreamStatus> get_status(rpc::GetStreamStatus);

  boost::asio::awaitable<std::optional<control::RpcError>> robot_not_ready();
  std::optional<control::RpcError> cannot_ramp_out(const std::string& method) const;
  template <typename State>
  boost::asio::awaitable<std::optional<control::RpcError>> ramped_out(std::string method);
  boost::asio::awaitable<void> end_program();
  boost::asio::awaitable<void> keep_corrected();
  boost::asio::awaitable<StoreResult<void>> keep_armed(std::string since);
  boost::asio::awaitable<void> keep_disarmed();
  void forget_fault_of_past_session();
  void acknowledge();
  void take_events();
  void look();
  void refresh_robot(const StreamStatus& status);
  void compare_modes(const StreamStatus& status);
  void check_serial_number(const StreamStatus& status);
  bool waits_for_serial() const;
  std::string why_unverified() const;
  void look_for_silence(const StreamStatus& status);
  void follow(const StreamStatus& status);
  std::string no_answer(const StreamStatus& now) const;
  std::string trouble(const StreamStatus& now) const;
  FaultText why_faulted(const StreamStatus& status) const;
  RobotCondition robot(const StreamStatus& status) const;

  CellParts parts_;
  CellRunner& runner_;
  StoreWatch& store_;
  DeviceService& devices_;
  ModelService& models_;
  StreamLog log_;
  LastMinute last_minute_;
  StreamState state_ = StreamState::Idle;  ///< when it was looked at last
  StreamStatus before_request_;            ///< when the stream was asked for last
  StreamStatus before_stream_;             ///< when its program ran
  RefusedPackets refused_;
  ControllerSignals controller_signals_;
  std::optional<std::optional<int>> tool_by_rsi_;  ///< that RSI named last, while it names one
  RobotCondition robot_;                           ///< when the stream was looked at last
  TimePoint modes_agreed_{};                       ///< by RSI and the state server, or one of them says none
  bool mode_differs_ = false;
  bool clamp_named_ = false;     ///< as the cause why the axes do not follow
  TimePoint proven_{};           ///< when packets could be answered, or none came
  bool kept_armed_ = false;      ///< by the store
  bool verified_ = false;        ///< the arm is the model's, and has not been out of sight since
  bool reports_serial_ = false;  ///< by the state server, so that a controller that comes back is waited for
  std::uint32_t acknowledged_ = 0;  ///< by an operator, so many times
};

}  // namespace truepose::daemon
