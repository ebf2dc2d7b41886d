#include "daemon/cell/device_service.hpp"

#include <algorithm>
#include <utility>

#include "core/arm/joint_units.hpp"
#include "daemon/campaign/arm_check.hpp"
#include "daemon/log/log.hpp"
#include "drivers/deadline.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;
using namespace std::chrono_literals;

namespace {

constexpr Duration kAskDevices = 1s;
constexpr Duration kAskTracker = 5s;
constexpr Duration kCheckAnswer = 5s;
constexpr Duration kOld = 3s;  // a state of the robot is not known any more

}  // namespace

DeviceService::DeviceService(const CellParts& parts, CellRunner& runner, StoreWatch& store,
                             std::function<rpc::CellStatus()> status)
    : parts_{parts},
      runner_{runner},
      store_{store},
      status_{std::move(status)},
      robot_{parts.robot, parts.clock},
      tracker_{parts.tracker},
      devices_{parts.config,
               {robot_, tracker_, parts.clock},
               &log_warning,
               [this](CellDevice device, const std::string& reason) { runner_.await(device, reason); }} {
  runner_.on(CellCommand::CloseDevices, [this](const std::string&) { close(); });
}

std::vector<Served<DeviceService>> DeviceService::methods() {
  return {&DeviceService::config, &DeviceService::status, &DeviceService::connect, &DeviceService::disconnect,
          &DeviceService::acknowledge};
}

Reply<rpc::SystemConfig> DeviceService::config(rpc::SystemConfig) {
  co_return rpc::SystemConfig::Result{config::cell_json(parts_.config)};
}

Reply<rpc::GetCellStatus> DeviceService::status(rpc::GetCellStatus) { co_return status_(); }

Reply<rpc::CellConnect> DeviceService::connect(rpc::CellConnect, std::string by) {
  if (auto refused = runner_.apply(ConnectRequested{}, "asked for by an operator", by))
    co_return std::unexpected(*refused);
  auto identities = co_await devices_.connect();
  if (!identities) {
    const DeviceError& error = identities.error();
    runner_.apply(ConnectFailed{{error.detail, error.what_to_do}}, error.detail);
    co_return std::unexpected(RpcError{ErrorCode::Device, runner_.fault_or(error.detail)});
  }
  runner_.apply(DevicesConnected{}, "robot and tracker are connected, and it is the right arm");
  co_return status_();
}

asio::awaitable<bool> DeviceService::connect_again() {
  constexpr Duration kPatience = 30s;  // less than an abort may take
  if (connected()) co_return true;
  const TimePoint until = parts_.clock.now() + kPatience;
  auto connecting = devices_.connect_missing(!robot_.connected(), !tracker_.connected());
  auto made = co_await drivers::before(parts_.clock, until, std::move(connecting));
  const std::string why = !made   ? "it takes longer than " + std::to_string(kPatience / 1s) + " s"
                          : *made ? ""
                                  : made->error().detail;
  if (!why.empty()) log_warning("robot and tracker are not connected again after the abort: " + why);
  co_return connected();
}

Reply<rpc::CellDisconnect> DeviceService::disconnect(rpc::CellDisconnect, std::string by) {
  if (auto refused = runner_.apply(DisconnectRequested{}, "asked for by an operator", by))
    co_return std::unexpected(*refused);
  co_return status_();
}

Reply<rpc::CellAcknowledge> DeviceService::acknowledge(rpc::CellAcknowledge, std::string by) {
  const bool of_the_store = store_.failing();
  std::optional<RpcError> unusable;
  if (of_the_store) unusable = co_await store_.acknowledge();
  // Whatever else there is to acknowledge, with the store or without; in most states nothing.
  const auto refused = runner_.acknowledge(by);
  if (refused && unusable) co_return std::unexpected(*unusable);
  if (refused && !of_the_store) co_return std::unexpected(*refused);
  co_return status_();
}

void DeviceService::close() {
  devices_.disconnect();
  runner_.faults().end(FaultCode::Tracker);
}

asio::awaitable<void> DeviceService::stop_robot() {
  auto stopped = co_await devices_.stop();
  if (!stopped) log_error("the arm could not be braked: " + stopped.error().detail);
}

asio::awaitable<void> DeviceService::watch() {
  for (TimePoint ask_tracker_at = parts_.clock.now();;) {
    // Taken before the questions: a wish that comes during one is not lost.
    auto wish = soon_.wait();
    if (may_be_asked()) co_await ask_robot();
    if (runner_.in<Armed>()) co_await refresh_robot();
    if (may_be_asked() && !tracker_.busy() && parts_.clock.now() >= ask_tracker_at) {
      co_await ask_tracker();
      ask_tracker_at = parts_.clock.now() + kAskTracker;
    }
    const TimePoint next = parts_.clock.now() + kAskDevices;
    co_await drivers::before(parts_.clock, next, std::move(wish));
  }
}

/// A campaign reconnects its lost devices itself.
asio::awaitable<void> DeviceService::ask_robot() {
  if (in_campaign() && !robot_.connected()) co_return;
  const TimePoint deadline = parts_.clock.now() + kCheckAnswer;
  auto asked = co_await robot_.state(deadline);
  if (!may_be_asked()) co_return;
  const bool may_stand = in_campaign() && !needs_.moving_arm;
  DeviceError why{Remedy::Retry, ""};
  if (!asked)
    why = device_error(asked.error());
  else if (!may_stand && !asked->ready)
    why.detail = drivers::not_ready_text(asked->why_not_ready);
  if (in_campaign()) {
    runner_.await(CellDevice::Controller, why.detail);
  } else if (!asked) {
    runner_.apply(DeviceLost{{why.detail, why.what_to_do}}, why.detail);
  }
}

/// An armed stream does without it.
asio::awaitable<void> DeviceService::refresh_robot() {
  const TimePoint deadline = parts_.clock.now() + kCheckAnswer;
  co_await robot_.look(deadline);
}

std::expected<drivers::RobotState, std::string> DeviceService::robot_state() const {
  const auto& state = robot_.last_state();
  if (!state) return std::unexpected(robot_.why_not());
  if (parts_.clock.now() - robot_.last_state_at() >= kOld)
    return std::unexpected("last answer more than " + std::to_string(kOld / 1s) + " s ago");
  return *state;
}

std::optional<std::string> DeviceService::arm_serial() const {
  if (robot_.connected()) return robot_.identity().serial;
  const auto state = robot_state();
  return state ? state->serial : std::nullopt;
}

std::string DeviceService::other_arm(const std::string& what, const std::string& serial) const {
  const auto now = arm_serial();
  return now ? daemon::other_arm(what, serial, *now) : std::string{};
}

/// The stream does not need the tracker; a cell that is ready to measure does.
asio::awaitable<void> DeviceService::ask_tracker() {
  if (in_campaign() && !(needs_.tracker && tracker_.connected())) co_return;
  const TimePoint deadline = parts_.clock.now() + kCheckAnswer;
  auto asked = co_await tracker_.check(deadline);
  const DeviceError why =
      asked ? DeviceError{Remedy::Retry, ""} : device_error(asked.error(), parts_.config.tracker);
  if (!asked && runner_.in<Ready>()) runner_.apply(DeviceLost{{why.detail, why.what_to_do}}, why.detail);
  if (in_campaign()) runner_.await(CellDevice::Tracker, why.detail);
  runner_.faults().stand(!asked && runner_.in<Streaming>(),
                         {FaultCode::Tracker, why.detail + "; the stream continues without it"});
}

std::string DeviceService::how_to_get_ready() const {
  const auto robot = robot_state();
  if (!runner_.in<Ready>() || !robot || robot->ready) return {};
  return drivers::not_ready_text(robot->why_not_ready);
}

rpc::RobotStatus DeviceService::robot_status() const {
  const bool connected = robot_.connected();
  const drivers::RobotIdentity known = connected ? robot_.identity() : drivers::RobotIdentity{};
  const drivers::RobotState robot = robot_.last_state().value_or(drivers::RobotState{});
  return {.connected = connected,
          .model = known.model,
          .serial = known.serial,
          .software = known.software,
          .ready = connected && robot.ready,
          .why_not_ready = connected ? robot.why_not_ready : robot_.why_not(),
          .q_deg = in_deg_mm(robot.q, parts_.config.robot.model)};
}

rpc::TrackerStatus DeviceService::tracker_status() const {
  const bool connected = tracker_.connected();
  const drivers::TrackerIdentity known = connected ? tracker_.identity() : drivers::TrackerIdentity{};
  return {.connected = connected,
          .model = known.model,
          .serial = known.serial,
          .firmware = known.firmware,
          .why_not_ready = connected ? "" : tracker_.why_not()};
}

}  // namespace truepose::daemon
