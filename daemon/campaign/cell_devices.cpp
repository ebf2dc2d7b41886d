#include "daemon/campaign/cell_devices.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "config/cell_setup.hpp"
#include "core/change/reference_pose.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/plan/scene.hpp"
#include "core/plan/tour.hpp"
#include "core/planted_bug.hpp"
#include "daemon/campaign/mean_reading.hpp"
#include "daemon/campaign/way_out.hpp"

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
constexpr int kLonger = 4;  // times, for a reading that scatters
constexpr Duration kAgain = 1s;
constexpr double kSmallTurn_rad = kRadPerDeg, kStays_rad = 0.2 * kRadPerDeg;
// An arm that is held by its drives or brakes; its encoders show less.
constexpr double kStill_rad = 0.001 * kRadPerDeg;
constexpr int kLooks = 5;
constexpr Duration kBetweenLooks = 200ms;

Duration until_tried_again() {
  return planted("a lost device is tried every twenty seconds") ? 20 * kAgain : kAgain;
}

std::string mm(double value) { return formatted("%.2f mm", value); }

Remedy remedy_of(drivers::RobotFault fault) {
  using drivers::RobotFault;
  switch (fault) {
    case RobotFault::Refused:
    case RobotFault::Aborted:
      return Remedy::Retry;
    case RobotFault::NotReady:
      return Remedy::WaitForRobot;
    case RobotFault::Unreachable:
    case RobotFault::Timeout:
    case RobotFault::Disconnected:
    case RobotFault::Protocol:
      return Remedy::ReconnectRobot;
  }
  return Remedy::ReconnectRobot;
}

Remedy remedy_of(drivers::TrackerFault fault) {
  using drivers::TrackerFault;
  switch (fault) {
    case TrackerFault::NoTarget:
    case TrackerFault::BeamBroken:
    case TrackerFault::Busy:
    case TrackerFault::Refused:
      return Remedy::Retry;
    case TrackerFault::NotReady:
    case TrackerFault::Unreachable:
    case TrackerFault::Timeout:
    case TrackerFault::Disconnected:
    case TrackerFault::Protocol:
      return Remedy::ReconnectTracker;
  }
  return Remedy::ReconnectTracker;
}

/// Each joint alone a little to the side where it has more room, and back: within its limits, and where the
/// arm comes near something, away from that.
std::vector<JointVector> small_motions(const Scene& scene, const JointVector& start) {
  PoseChecker checker{scene};
  std::vector<JointVector> motions;
  for (std::size_t i = 0; i < scene.robot.joints.size(); ++i) {
    const Joint& joint = scene.robot.joints[i];
    const auto at = static_cast<Eigen::Index>(i);
    JointVector q = start, other = start;
    q[at] += start[at] < (joint.min + joint.max) / 2 ? kSmallTurn_rad : -kSmallTurn_rad;
    other[at] -= q[at] - start[at];
    const double spare_mm = checker.spare_mm(q);
    if (spare_mm < 0 && within_limits(scene.robot, other) && checker.spare_mm(other) > spare_mm) q = other;
    motions.insert(motions.end(), {q, start});
  }
  return motions;
}

}  // namespace

DeviceError device_error(const drivers::RobotError& error) {
  return {.remedy = remedy_of(error.fault),
          .detail = "robot: " + error.detail,
          .what_to_do = way_out(error.fault)};
}

DeviceError device_error(const drivers::TrackerError& error, const config::TrackerConfig& tracker) {
  using drivers::TrackerFault;
  return {.remedy = remedy_of(error.fault),
          .detail = "tracker: " + error.detail,
          .beam_lost = error.fault == TrackerFault::NoTarget || error.fault == TrackerFault::BeamBroken,
          .what_to_do = way_out(error.fault, tracker)};
}

CellDevices::CellDevices(const config::CellConfig& config, CampaignDevices devices, OnTrouble on_trouble,
                         OnWaiting on_waiting)
    : config_{config},
      robot_{devices.robot},
      tracker_{devices.tracker},
      clock_{devices.clock},
      on_trouble_{std::move(on_trouble)},
      on_waiting_{std::move(on_waiting)} {}

CellDevices::Outcome<Identities> CellDevices::connect(ArmProof proof, bool with_tracker) {
  await(CellDevice::Controller, "it has to connect");
  auto robot = co_await connect_robot(proof);
  if (!robot) co_return std::unexpected(robot.error());
  await(CellDevice::Controller, {});
  if (!with_tracker) co_return Identities{*std::move(robot), {}};
  await(CellDevice::Tracker, "it has to connect");
  auto tracker = co_await connect_tracker();
  if (!tracker) co_return std::unexpected(tracker.error());
  await(CellDevice::Tracker, {});
  co_return Identities{*std::move(robot), *std::move(tracker)};
}

CellDevices::Outcome<void> CellDevices::recover(DeviceError lost) {
  const CellDevice device =
      lost.remedy == Remedy::ReconnectTracker ? CellDevice::Tracker : CellDevice::Controller;
  for (std::string reported;;) {
    await(device, lost.detail);
    auto outcome = co_await apply_remedy(lost.remedy);
    if (outcome || outcome.error().remedy == Remedy::WrongArm) {
      await(device, {});
      co_return outcome;
    }
    lost = outcome.error();
    if (reported != lost.detail) on_trouble_(lost.detail + "; trying again");
    reported = lost.detail;
    co_await clock_.sleep_until(clock_.now() + until_tried_again());
  }
}

CellDevices::Outcome<void> CellDevices::connect_missing(bool robot, bool tracker) {
  if (robot) {
    auto connected = co_await connect_robot();
    if (!connected) co_return std::unexpected(connected.error());
  }
  if (tracker) {
    auto connected = co_await connect_tracker();
    if (!connected) co_return std::unexpected(connected.error());
  }
  co_return std::expected<void, DeviceError>{};
}

CellDevices::Outcome<void> CellDevices::apply_remedy(Remedy remedy) {
  auto connected =
      co_await connect_missing(remedy == Remedy::ReconnectRobot, remedy == Remedy::ReconnectTracker);
  if (!connected || remedy == Remedy::ReconnectTracker) co_return connected;
  co_return co_await wait_for_robot();
}

/// A robot program that does not answer stands for a reason that the state server knows.
asio::awaitable<DeviceError> CellDevices::explained(DeviceError error) {
  auto seen = co_await robot_.look(clock_.now() + kAnswer);
  if (seen && !seen->ready) {
    error.detail = drivers::not_ready_text(seen->why_not_ready);
    error.what_to_do.clear();
  }
  co_return error;
}

CellDevices::Outcome<drivers::RobotIdentity> CellDevices::connect_robot(ArmProof proof) {
  auto identity = co_await robot_.connect(clock_.now() + kRobotConnect);
  if (!identity) {
    auto error = co_await explained(device_error(identity.error()));
    co_return std::unexpected(std::move(error));
  }
  auto state = co_await robot_.state(clock_.now() + kAnswer);
  if (!state) co_return std::unexpected(device_error(state.error()));
  const ControllerPose here{state->q, state->X_BF_reported};
  const bool later = proof == ArmProof::ByMotion && is_undecided(config_.robot, {&here, 1});
  const auto checked =
      later ? check_type(config_.robot, *identity, *state) : check_arm(config_.robot, *identity, *state);
  if (!checked) co_return std::unexpected(checked.error());
  co_return *std::move(identity);
}

CellDevices::Outcome<drivers::TrackerIdentity> CellDevices::connect_tracker() {
  auto identity = co_await tracker_.connect(clock_.now() + kTrackerConnect);
  if (!identity) co_return std::unexpected(device_error(identity.error(), config_.tracker));
  co_return *std::move(identity);
}

CellDevices::Outcome<void> CellDevices::wait_for_robot() {
  for (std::string reported;;) {
    auto state = co_await robot_.state(clock_.now() + kAnswer);
    if (!state) co_return std::unexpected(device_error(state.error()));
    if (state->ready) co_return std::expected<void, DeviceError>{};
    await(CellDevice::Controller, drivers::not_ready_text(state->why_not_ready));
    if (reported != state->why_not_ready) on_trouble_("robot: not ready, waiting: " + state->why_not_ready);
    reported = state->why_not_ready;
    co_await clock_.sleep_until(clock_.now() + kAgain);
  }
}

CellDevices::Outcome<JointVector> CellDevices::position() {
  auto state = co_await robot_.state(clock_.now() + kAnswer);
  if (!state) co_return std::unexpected(device_error(state.error()));
  co_return state->q;
}

CellDevices::Outcome<JointVector> CellDevices::standstill() {
  JointVector q;
  for (int looks = 0; looks < kLooks; ++looks) {
    if (looks > 0) co_await clock_.sleep_until(clock_.now() + kBetweenLooks);
    auto state = co_await robot_.look(clock_.now() + kAnswer);
    if (!state) co_return std::unexpected(device_error(state.error()));
    await(CellDevice::Controller, {});
    if (looks == 0) q = state->q;
    if (state->moving || !has_stayed(state->q, q))
      co_return std::unexpected(DeviceError{Remedy::Retry, "robot: the arm moves"});
  }
  co_return q;
}

// Written so that a NaN has not.
bool CellDevices::has_stayed(const JointVector& q, const JointVector& before) {
  return ((q - before).array().abs() <= kStill_rad).all();
}

CellDevices::Outcome<drivers::RobotState> CellDevices::ready_state() {
  auto state = co_await robot_.state(clock_.now() + kAnswer);
  if (!state) co_return std::unexpected(device_error(state.error()));
  if (!state->ready)
    co_return std::unexpected(
        DeviceError{Remedy::WaitForRobot, drivers::not_ready_text(state->why_not_ready)});
  co_return *std::move(state);
}

CellDevices::Outcome<JointVector> CellDevices::drive(JointVector q) {
  auto state = co_await ready_state();
  if (!state) co_return std::unexpected(state.error());
  const drivers::MoveCommand command{q, config_.campaign.speed_percent, config_.campaign.settle};
  // Twice the time at full acceleration: ramps take their share, and the override may be turned down on the
  // way.
  const double speed = command.speed_percent / 100 * std::max(state->override_percent, 1.0) / 100;
  const std::chrono::duration<double> travel{2 * travel_time_s(config_.robot.model, state->q, q) / speed};
  const TimePoint deadline =
      clock_.now() + std::chrono::duration_cast<Duration>(travel) + command.settle + kMoveReserve;
  auto reached = co_await robot_.move(command, deadline);
  if (!reached) co_return std::unexpected(device_error(reached.error()));
  co_return *std::move(reached);
}

/// What the controller says of the arm that has come to q.
CellDevices::Outcome<ControllerPose> CellDevices::pose_at(JointVector q) {
  auto state = co_await robot_.state(clock_.now() + kAnswer);
  if (!state) co_return std::unexpected(device_error(state.error()));
  Eigen::Index worst = 0;
  const double off = (state->q - q).cwiseAbs().maxCoeff(&worst);
  // Written so that a NaN is refused as well.
  if (off <= kStays_rad) co_return ControllerPose{state->q, state->X_BF_reported};
  co_return std::unexpected(
      DeviceError{Remedy::Retry, "robot: joint " + std::to_string(worst + 1) +
                                     " does not stand where the controller said that it had come to"});
}

CellDevices::Outcome<JointVector> CellDevices::move(JointVector q) {
  auto reached = co_await drive(q);
  if (!reached) co_return reached;
  auto pose = co_await pose_at(*reached);
  if (!pose) co_return std::unexpected(pose.error());
  const auto ours = check_poses(config_.robot, {&*pose, 1});
  if (!ours) co_return std::unexpected(ours.error());
  co_return reached;
}

CellDevices::Outcome<void> CellDevices::prove_arm() {
  auto start = co_await ready_state();
  if (!start) co_return std::unexpected(start.error());
  std::vector<ControllerPose> poses{{start->q, start->X_BF_reported}};
  for (const JointVector& q : small_motions(config::scene_of(config_), start->q)) {
    auto reached = co_await drive(q);
    if (!reached) co_return std::unexpected(reached.error());
    auto pose = co_await pose_at(*reached);
    if (!pose) co_return std::unexpected(pose.error());
    poses.push_back(*std::move(pose));
    if (is_undecided(config_.robot, poses)) continue;
    auto ours = check_poses(config_.robot, poses);
    if (!ours) co_return ours;
  }
  co_return check_poses(config_.robot, poses);
}

CellDevices::Outcome<CellDevices::MeasureResult> CellDevices::measure(MeasureRequest request) {
  auto aimed = co_await tracker_.aim(request.p_W_mm, request.search_mm, clock_.now() + kAim);
  if (!aimed) co_return std::unexpected(device_error(aimed.error(), config_.tracker));
  auto point = co_await readings(request.readings);
  if (!point) co_return std::unexpected(point.error());
  MeasureResult result{*point, {}};
  if (request.two_face) {
    auto turned = co_await turn_over();
    if (!turned) co_return std::unexpected(turned.error());
    auto other = co_await readings(request.readings);
    if (!other) co_return std::unexpected(other.error());
    const std::array both{*point, *other};
    result = {mean_reading(both), *point};
  }
  const double off_mm = (result.point.p_WS_mm - request.p_W_mm).norm();
  if (off_mm <= request.gate_mm) co_return result;
  co_return std::unexpected(DeviceError{Remedy::Retry, "tracker: wrong reflector: found " + mm(off_mm) +
                                                           " from where ours should be, allowed are " +
                                                           mm(request.gate_mm)});
}

CellDevices::Outcome<drivers::SmrPoint> CellDevices::readings(int count) {
  std::vector<drivers::SmrPoint> all;
  for (int n = 1; n <= count; ++n) {
    auto point = co_await steady_reading();
    if (!point) co_return std::unexpected(point.error());
    all.push_back(*point);
  }
  co_return mean_reading(all);
}

CellDevices::Outcome<drivers::SmrPoint> CellDevices::steady_reading() {
  auto point = co_await reading(1);
  if (!point) co_return std::unexpected(point.error());
  const auto steady = check_scatter(*point);
  if (steady) co_return *point;
  on_trouble_(steady.error().detail + "; measuring it " + std::to_string(kLonger) + " times as long");
  auto longer = co_await reading(kLonger);
  if (!longer) co_return std::unexpected(longer.error());
  const auto still = check_scatter(*longer);
  if (!still) co_return std::unexpected(still.error());
  co_return *longer;
}

CellDevices::Outcome<drivers::SmrPoint> CellDevices::reading(int times) {
  const Duration time = times * config_.tracker.measure;
  tracker_.average_over(time);
  auto point = co_await tracker_.measure(clock_.now() + time + kMeasureReserve);
  if (!point) co_return std::unexpected(device_error(point.error(), config_.tracker));
  co_return *point;
}

CellDevices::Outcome<void> CellDevices::turn_over() {
  auto turned = co_await tracker_.turn_over(clock_.now() + kAim);
  if (!turned) co_return std::unexpected(device_error(turned.error(), config_.tracker));
  co_return std::expected<void, DeviceError>{};
}

std::expected<void, DeviceError> CellDevices::check_scatter(const drivers::SmrPoint& point) const {
  const config::TrackerConfig& tracker = config_.tracker;
  const MeasurementNoise stated{tracker.noise, config_.robot.repeatability_mm};
  const double stated_mm = std::sqrt(reading_covariance(point.p_WS_mm, stated).trace() / 3);
  const double most_mm = tracker.max_std_mm > 0 ? tracker.max_std_mm : kMostScatter * stated_mm;
  const double found_mm = point.std_mm.maxCoeff();
  // Written so that a NaN is refused as well.
  if (found_mm <= most_mm) return {};
  const std::string allowed =
      tracker.max_std_mm > 0 ? formatted("%.3f mm (tracker.max_std_mm)", most_mm)
                             : formatted("%.0f times the %.3f mm of tracker.noise and robot.repeatability_mm",
                                         kMostScatter, stated_mm);
  return std::unexpected(DeviceError{
      Remedy::Retry, formatted("tracker: the readings of this point scatter by %.3f mm, allowed are %s (does "
                               "the arm vibrate, or the air shimmer?)",
                               found_mm, allowed.c_str())});
}

CellDevices::Outcome<void> CellDevices::stop() {
  auto stopped = co_await robot_.stop(clock_.now() + kAnswer);
  if (!stopped) co_return std::unexpected(device_error(stopped.error()));
  co_return std::expected<void, DeviceError>{};
}

void CellDevices::disconnect() noexcept {
  robot_.disconnect();
  tracker_.disconnect();
}

}  // namespace truepose::daemon
