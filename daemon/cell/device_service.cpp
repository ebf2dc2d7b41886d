#include "daemon/cell/device_service.hpp"

#include <utility>

#include "daemon/log/log.hpp"
#include "proto/record/arm_document.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;
using namespace std::chrono_literals;

namespace {

constexpr Duration kAskDevices = 1s;
constexpr Duration kAskTracker = 5s;
constexpr Duration kCheckAnswer = 5s;
constexpr Duration kOld = 3s;  // a state of the robot is not known any more
constexpr const char* kTrackerFault = "E_TRACKER";

std::string address(const config::Endpoint& endpoint) {
  return endpoint.host + ":" + std::to_string(endpoint.port);
}

json::object config_json(const config::CellConfig& config) {
  return {{"name", config.name},
          {"robot",
           {{"file", config.robot.file.string()},
            {"model", config.robot.model.name},
            {"eki_motion", address(config.robot.eki_motion)},
            {"eki_state", address(config.robot.eki_state)},
            {"expect_model", config.robot.expect_model}}},
          {"stream",
           {{"listen", address(config.stream.listen)},
            {"ethernet_xml", config.stream.ethernet_xml.string()},
            {"max_step_deg", config.stream.max_step_deg},
            {"max_total_deg", config.stream.max_total_deg},
            {"ramp_ms", config.stream.ramp.count()}}},
          {"tracker",
           {{"address", address(config.tracker.address)},
            {"reflector", config.tracker.reflector},
            {"search_mm", config.tracker.search_mm},
            {"gate_mm", config.tracker.gate_mm}}},
          {"campaign",
           {{"identify_poses", config.campaign.identify_poses},
            {"validate_poses", config.campaign.validate_poses},
            {"seed", config.campaign.seed},
            {"speed_percent", config.campaign.speed_percent},
            {"remeasure", config.campaign.remeasure}}},
          {"control", {{"listen", address(config.control.listen)}}},
          {"store", config.store.string()}};
}

}  // namespace

DeviceService::DeviceService(const CellParts& parts, CellRunner& runner, std::function<json::object()> status)
    : parts_{parts},
      runner_{runner},
      status_{std::move(status)},
      devices_{parts.config,
               {parts.robot, parts.tracker, parts.clock},
               &log_warning,
               [this](CellDevice device, const std::string& reason) {
                 runner_.apply(DeviceAwaited{device, reason}, reason);
               }} {
  runner_.on(CellCommand::CloseDevices, [this](const std::string&) { close(); });
}

std::vector<Method<DeviceService>> DeviceService::methods() {
  return {{"system.config", &DeviceService::config},
          {"cell.status", &DeviceService::status},
          {"cell.connect", &DeviceService::connect},
          {"cell.disconnect", &DeviceService::disconnect},
          {"cell.acknowledge", &DeviceService::acknowledge}};
}

MethodReply DeviceService::config(json::object params) {
  if (auto wrong = no_parameters(params)) co_return std::unexpected(*wrong);
  co_return json::object{{"config", config_json(parts_.config)}};
}

MethodReply DeviceService::status(json::object params) {
  if (auto wrong = no_parameters(params)) co_return std::unexpected(*wrong);
  co_return status_();
}

MethodResult DeviceService::request(const json::object& params, const CellEvent& event,
                                    const std::string& reason) {
  if (auto refused = runner_.request(params, event, reason)) return std::unexpected(*refused);
  return status_();
}

MethodReply DeviceService::connect(json::object params) {
  const MethodResult accepted = request(params, ConnectRequested{}, "asked for by an operator");
  if (!accepted) co_return accepted;
  auto identities = co_await devices_.connect();
  if (!identities) {
    runner_.apply(ConnectFailed{identities.error().detail}, identities.error().detail);
    co_return std::unexpected(RpcError{ErrorCode::Device, identities.error().detail});
  }
  identities_ = *identities;
  runner_.apply(DevicesConnected{}, "robot and tracker are connected, and it is the right arm");
  co_return status_();
}

MethodReply DeviceService::disconnect(json::object params) {
  co_return request(params, DisconnectRequested{}, "asked for by an operator");
}

MethodReply DeviceService::acknowledge(json::object params) {
  co_return request(params, AcknowledgeRequested{}, "acknowledged by an operator");
}

void DeviceService::close() {
  devices_.disconnect();
  identities_.reset();
  robot_state_.reset();
  robot_not_told_.clear();
  runner_.faults().end(kTrackerFault);
}

/// A campaign talks with the devices itself.
asio::awaitable<void> DeviceService::watch() {
  for (TimePoint ask_tracker_at = parts_.clock.now();;) {
    asked_ = true;
    if (may_be_asked()) co_await ask_robot();
    if (runner_.in<Armed>()) co_await look_at_robot();
    if (may_be_asked() && parts_.clock.now() >= ask_tracker_at) {
      co_await ask_tracker();
      ask_tracker_at = parts_.clock.now() + kAskTracker;
    }
    asked_ = false;
    answered_.notify();
    const TimePoint next = parts_.clock.now() + kAskDevices;
    co_await parts_.clock.sleep_until(next);
  }
}

asio::awaitable<void> DeviceService::unasked() {
  while (asked_) co_await answered_.wait();
}

asio::awaitable<void> DeviceService::ask_robot() {
  const TimePoint deadline = parts_.clock.now() + kCheckAnswer;
  auto asked = co_await parts_.robot.state(deadline);
  if (asked) {
    take(*std::move(asked));
  } else if (may_be_asked()) {
    runner_.apply(DeviceLost{"robot: " + asked.error().detail}, asked.error().detail);
  }
}

/// An armed stream does without it.
asio::awaitable<void> DeviceService::look_at_robot() {
  const TimePoint deadline = parts_.clock.now() + kCheckAnswer;
  auto seen = co_await parts_.robot.look(deadline);
  if (!runner_.in<Armed>()) co_return;
  if (seen) co_return take(*std::move(seen));
  robot_state_.reset();
  robot_not_told_ = seen.error().detail;
}

void DeviceService::take(drivers::RobotState state) {
  robot_state_ = std::move(state);
  robot_told_ = parts_.clock.now();
}

std::expected<drivers::RobotState, std::string> DeviceService::robot_state() const {
  if (!robot_state_) return std::unexpected(robot_not_told_.empty() ? "not asked yet" : robot_not_told_);
  if (parts_.clock.now() - robot_told_ >= kOld) return std::unexpected("told more than 3 s ago");
  return *robot_state_;
}

/// The stream does without the tracker; whoever is ready to measure does not.
asio::awaitable<void> DeviceService::ask_tracker() {
  const TimePoint deadline = parts_.clock.now() + kCheckAnswer;
  auto asked = co_await parts_.tracker.check(deadline);
  const std::string why = asked ? "" : "tracker: " + asked.error().detail;
  if (!asked && runner_.in<Ready>()) runner_.apply(DeviceLost{why}, why);
  runner_.faults().stand(!asked && runner_.in<Streaming>(),
                         {kTrackerFault, "warning", why + "; the stream goes on without it"});
}

json::object DeviceService::robot_json() const {
  const Identities known = identities_.value_or(Identities{});
  const drivers::RobotState robot = robot_state_.value_or(drivers::RobotState{});
  return {{"connected", identities_.has_value()},
          {"model", known.robot.model},
          {"serial", known.robot.serial},
          {"software", known.robot.software},
          {"ready", identities_ && robot.ready},
          {"why_not_ready", identities_ ? robot.why_not_ready : "not connected"},
          {"q_deg", record::joints_json(robot.q, parts_.config.robot.model)}};
}

json::object DeviceService::tracker_json() const {
  const Identities known = identities_.value_or(Identities{});
  return {{"connected", identities_.has_value() && !runner_.faults().stands(kTrackerFault)},
          {"model", known.tracker.model},
          {"serial", known.tracker.serial},
          {"firmware", known.tracker.firmware},
          {"why_not_ready", identities_ ? "" : "not connected"}};
}

}  // namespace truepose::daemon
