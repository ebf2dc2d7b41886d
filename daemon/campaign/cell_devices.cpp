#include "daemon/campaign/cell_devices.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/judge/calibration_doubts.hpp"
#include "core/plan/tour.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using namespace std::chrono_literals;

namespace {

constexpr Duration kRobotConnect = 10s;
constexpr Duration kTrackerConnect = 180s;  // a cold start's initialisation included
constexpr Duration kAnswer = 5s;
constexpr Duration kMoveReserve = 30s;
constexpr Duration kAim = 40s;
constexpr Duration kMeasureReserve = 15s;
constexpr Duration kFirstPause = 1s;
constexpr Duration kLongestPause = 30s;

std::string mm(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mm", value);
  return text;
}

/// What to do about a robot's error.
DeviceError robot_error(const drivers::RobotError& error) {
  using drivers::RobotFault;
  const std::string detail = "robot: " + error.detail;
  switch (error.fault) {
    case RobotFault::Refused:
    case RobotFault::Aborted:
      return {Remedy::Retry, detail};
    case RobotFault::NotReady:
      return {Remedy::WaitForRobot, detail};
    case RobotFault::Unreachable:
    case RobotFault::Timeout:
    case RobotFault::Disconnected:
    case RobotFault::Protocol:
      return {Remedy::ReconnectRobot, detail};
  }
  return {Remedy::ReconnectRobot, detail};
}

DeviceError tracker_error(const drivers::TrackerError& error) {
  using drivers::TrackerFault;
  const std::string detail = "tracker: " + error.detail;
  switch (error.fault) {
    case TrackerFault::NoTarget:
    case TrackerFault::BeamBroken:
      return {Remedy::Retry, detail, true};
    case TrackerFault::Busy:
    case TrackerFault::Refused:
      return {Remedy::Retry, detail};
    case TrackerFault::NotReady:
    case TrackerFault::Unreachable:
    case TrackerFault::Timeout:
    case TrackerFault::Disconnected:
    case TrackerFault::Protocol:
      return {Remedy::ReconnectTracker, detail};
  }
  return {Remedy::ReconnectTracker, detail};
}

/// Largest distance that the flange's origin and a point 100 mm along each of its axes are apart in two
/// poses.
double deviation_mm(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B) {
  double largest = (A.translation() - B.translation()).norm();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d tip = 100 * Eigen::Vector3d::Unit(axis);
    largest = std::max(largest, (A * tip - B * tip).norm());
  }
  return largest;
}

}  // namespace

CellDevices::CellDevices(const config::CellConfig& config, CampaignDevices devices, OnTrouble on_trouble,
                         OnWaiting on_waiting)
    : config_{config},
      robot_{devices.robot},
      tracker_{devices.tracker},
      clock_{devices.clock},
      on_trouble_{std::move(on_trouble)},
      on_waiting_{std::move(on_waiting)} {}

CellDevices::Outcome<Identities> CellDevices::connect() {
  disconnect();
  auto robot = co_await connect_robot();
  if (!robot) co_return std::unexpected(robot.error());
  await(CellDevice::Tracker, "it has to connect");
  auto tracker = co_await connect_tracker();
  if (!tracker) co_return std::unexpected(tracker.error());
  await(CellDevice::Tracker, {});
  Identities identities{*std::move(robot), *std::move(tracker)};
  co_return identities;
}

CellDevices::Outcome<void> CellDevices::recover(DeviceError lost) {
  if (lost.remedy == Remedy::WaitForRobot) {
    auto ready = co_await wait_for_robot();
    if (ready || ready.error().remedy != Remedy::ReconnectRobot) co_return ready;
    lost = ready.error();
  }
  const CellDevice device =
      lost.remedy == Remedy::ReconnectTracker ? CellDevice::Tracker : CellDevice::Controller;
  await(device, lost.detail);
  const TimePoint give_up = clock_.now() + kPatience;
  for (Duration pause = kFirstPause;; pause = std::min<Duration>(2 * pause, kLongestPause)) {
    std::optional<DeviceError> error;
    if (device == CellDevice::Controller) {
      auto connected = co_await connect_robot();
      if (!connected) error = connected.error();
    } else {
      auto connected = co_await connect_tracker();
      if (!connected) error = connected.error();
    }
    await(device, error ? error->detail : "");
    if (!error) co_return std::expected<void, DeviceError>{};
    if (error->remedy == Remedy::WrongArm) co_return std::unexpected(*error);
    const TimePoint next = clock_.now() + pause;
    if (next > give_up) {
      co_return std::unexpected(DeviceError{Remedy::GiveUp, error->detail + "; gave up waiting for it"});
    }
    on_trouble_(error->detail + "; trying again");
    co_await clock_.sleep_until(next);
  }
}

CellDevices::Outcome<drivers::RobotIdentity> CellDevices::connect_robot() {
  robot_.disconnect();
  const TimePoint deadline = clock_.now() + kRobotConnect;
  auto identity = co_await robot_.connect(deadline);
  if (!identity) co_return std::unexpected(robot_error(identity.error()));
  const TimePoint answer = clock_.now() + kAnswer;
  auto state = co_await robot_.state(answer);
  if (!state) co_return std::unexpected(robot_error(state.error()));
  const auto checked = check_arm(config_.robot, *identity, *state);
  if (!checked) co_return std::unexpected(checked.error());
  co_return *std::move(identity);
}

CellDevices::Outcome<drivers::TrackerIdentity> CellDevices::connect_tracker() {
  tracker_.disconnect();
  const TimePoint deadline = clock_.now() + kTrackerConnect;
  auto identity = co_await tracker_.connect(deadline);
  if (!identity) co_return std::unexpected(tracker_error(identity.error()));
  co_return *std::move(identity);
}

std::expected<void, DeviceError> check_arm(const config::RobotConfig& robot,
                                           const drivers::RobotIdentity& identity,
                                           const drivers::RobotState& state) {
  if (identity.model.find(robot.expect_model) == std::string::npos) {
    return std::unexpected(DeviceError{Remedy::WrongArm, "wrong arm: the controller says " + identity.model +
                                                             ", the cell expects " + robot.expect_model});
  }
  if (state.q.size() != robot.model.joint_count()) {
    return std::unexpected(DeviceError{Remedy::WrongArm, "wrong arm: the controller reports " +
                                                             std::to_string(state.q.size()) + " joints, " +
                                                             robot.model.name + " has " +
                                                             std::to_string(robot.model.joint_count())});
  }
  const double off_mm = deviation_mm(state.X_BF_reported, forward_kinematics(robot.model, state.q));
  // Written so that a NaN is refused as well.
  if (off_mm <= robot.max_fk_deviation_mm) return {};
  return std::unexpected(DeviceError{
      Remedy::WrongArm, "wrong arm or wrong robot file: the controller's flange pose and the kinematics of " +
                            robot.model.name + " are " + mm(off_mm) + " apart, allowed are " +
                            mm(robot.max_fk_deviation_mm) + " (are tool and base 0?)"});
}

CellDevices::Outcome<void> CellDevices::wait_for_robot() {
  const TimePoint give_up = clock_.now() + kPatience;
  for (std::string told;;) {
    const TimePoint deadline = clock_.now() + kAnswer;
    auto state = co_await robot_.state(deadline);
    if (!state) co_return std::unexpected(robot_error(state.error()));
    await(CellDevice::Controller, state->ready ? "" : state->why_not_ready);
    if (state->ready) co_return std::expected<void, DeviceError>{};
    if (clock_.now() > give_up) {
      co_return std::unexpected(
          DeviceError{Remedy::GiveUp, "robot: not ready for too long: " + state->why_not_ready});
    }
    if (told != state->why_not_ready) on_trouble_("robot: not ready, waiting: " + state->why_not_ready);
    told = state->why_not_ready;
    const TimePoint next = clock_.now() + kFirstPause;
    co_await clock_.sleep_until(next);
  }
}

CellDevices::Outcome<JointVector> CellDevices::position() {
  const TimePoint deadline = clock_.now() + kAnswer;
  auto state = co_await robot_.state(deadline);
  if (!state) co_return std::unexpected(robot_error(state.error()));
  co_return state->q;
}

CellDevices::Outcome<JointVector> CellDevices::move(JointVector q) {
  const TimePoint answer = clock_.now() + kAnswer;
  auto state = co_await robot_.state(answer);
  if (!state) co_return std::unexpected(robot_error(state.error()));
  if (!state->ready)
    co_return std::unexpected(DeviceError{Remedy::WaitForRobot, "robot: " + state->why_not_ready});

  drivers::MoveCommand command;
  command.q = q;
  command.speed_percent = config_.campaign.speed_percent;
  command.settle = config_.campaign.settle;
  // Twice the time at full acceleration: ramps take their share, and the override may be turned down on the
  // way.
  const double speed = command.speed_percent / 100 * std::max(state->override_percent, 1.0) / 100;
  const std::chrono::duration<double> travel{2 * travel_time_s(config_.robot.model, state->q, q) / speed};
  const TimePoint deadline =
      clock_.now() + std::chrono::duration_cast<Duration>(travel) + command.settle + kMoveReserve;
  auto reached = co_await robot_.move(command, deadline);
  if (!reached) co_return std::unexpected(robot_error(reached.error()));
  co_return *std::move(reached);
}

CellDevices::Outcome<drivers::SmrPoint> CellDevices::measure(Eigen::Vector3d p_W_mm, double search_radius_mm,
                                                             double gate_mm, int readings) {
  const TimePoint aimed_by = clock_.now() + kAim;
  auto aimed = co_await tracker_.aim(p_W_mm, search_radius_mm, aimed_by);
  if (!aimed) co_return std::unexpected(tracker_error(aimed.error()));
  drivers::SmrPoint mean;
  for (int n = 1; n <= readings; ++n) {
    const TimePoint measured_by = clock_.now() + config_.tracker.measure + kMeasureReserve;
    auto point = co_await tracker_.measure(measured_by);
    if (!point) co_return std::unexpected(tracker_error(point.error()));
    const auto steady = check_scatter(*point);
    if (!steady) co_return std::unexpected(steady.error());
    const Eigen::Vector3d sum_mm = mean.p_WS_mm * (n - 1) + point->p_WS_mm;
    mean = *point;
    mean.p_WS_mm = sum_mm / n;
  }
  const double off_mm = (mean.p_WS_mm - p_W_mm).norm();
  if (off_mm <= gate_mm) co_return mean;
  co_return std::unexpected(DeviceError{Remedy::Retry, "tracker: wrong reflector: found " + mm(off_mm) +
                                                           " from where ours should be, allowed are " +
                                                           mm(gate_mm)});
}

std::expected<void, DeviceError> CellDevices::check_scatter(const drivers::SmrPoint& point) const {
  const MeasurementNoise stated{config_.tracker.noise, config_.robot.repeatability_mm};
  const double stated_mm = std::sqrt(reading_covariance(point.p_WS_mm, stated).trace() / 3);
  const double found_mm = point.std_mm.maxCoeff();
  // Written so that a NaN is refused as well.
  if (found_mm <= kMostScatter * stated_mm) return {};
  char text[300];
  std::snprintf(
      text, sizeof text,
      "tracker: the readings of this point scatter by %.3f mm, allowed are %.0f times the %.3f mm of "
      "tracker.noise and robot.repeatability_mm (does the arm vibrate, or the air shimmer?)",
      found_mm, kMostScatter, stated_mm);
  return std::unexpected(DeviceError{Remedy::Retry, text});
}

asio::awaitable<void> CellDevices::stop() {
  const TimePoint deadline = clock_.now() + kAnswer;
  auto stopped = co_await robot_.stop(deadline);
  if (!stopped) on_trouble_("robot: could not be stopped: " + stopped.error().detail);
}

void CellDevices::disconnect() noexcept {
  robot_.disconnect();
  tracker_.disconnect();
}

}  // namespace truepose::daemon
