#include "daemon/device_probe.hpp"

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/use_future.hpp>

#include "daemon/campaign/arm_check.hpp"
#include "daemon/cell_tracker.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "drivers/kuka/eki_robot.hpp"

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;

/// Runs one conversation with a device to its end.
template <typename T>
T result_of(asio::io_context& io, asio::awaitable<T> conversation) {
  auto result = asio::co_spawn(io, std::move(conversation), asio::use_future);
  io.run();
  return result.get();
}

using RobotResult = std::expected<RobotObservation, drivers::RobotError>;

asio::awaitable<RobotResult> look_at(drivers::KukaEkiRobot& robot, drivers::TimePoint deadline) {
  const auto identity = co_await robot.inspect(deadline);
  if (!identity) co_return std::unexpected(identity.error());
  const auto state = co_await robot.state(deadline);
  robot.disconnect();
  if (!state) co_return std::unexpected(state.error());
  RobotObservation seen{*identity, *state};
  co_return seen;
}

CheckFinding robot_finding(const config::RobotConfig& config, const RobotObservation& seen) {
  const std::string who =
      "robot: " + seen.identity.model + ", serial " + seen.identity.serial + ", " + seen.identity.software;
  if (const auto right = check_arm(config, seen.identity, seen.state); !right)
    return {CheckFinding::Level::Failure, who + ": " + right.error().detail};
  if (!seen.state.ready)
    return {CheckFinding::Level::Warning, who + ": cannot be moved now: " + seen.state.why_not_ready};
  return {CheckFinding::Level::Good, who};
}

}  // namespace

RobotResult observe_robot(const config::RobotConfig& config) {
  if (auto why = why_unfit(config.model))
    return std::unexpected(drivers::RobotError{drivers::RobotFault::Refused, *std::move(why)});
  asio::io_context io;
  drivers::SteadyClock clock;
  drivers::KukaEkiRobot robot{io.get_executor(),
                              clock,
                              {.host = config.eki_motion.host,
                               .motion_port = config.eki_motion.port,
                               .state_port = config.eki_state.port,
                               .joint_count = static_cast<int>(config.model.joint_count())}};
  return result_of(io, look_at(robot, clock.now() + kProbeTime));
}

std::expected<drivers::TrackerIdentity, drivers::TrackerError> observe_tracker(
    const config::TrackerConfig& config) {
  asio::io_context io;
  drivers::SteadyClock clock;
  const auto tracker = cell_tracker(config, io.get_executor(), clock);
  return result_of(io, tracker->inspect(clock.now() + kProbeTime));
}

std::vector<CheckFinding> probe(const config::CellConfig& config) {
  const auto robot = observe_robot(config.robot);
  const auto tracker = observe_tracker(config.tracker);
  return {robot ? robot_finding(config.robot, *robot)
                : CheckFinding{CheckFinding::Level::Failure, "robot: " + robot.error().detail},
          tracker ? CheckFinding{CheckFinding::Level::Good, "tracker: " + tracker->model + ", serial " +
                                                                tracker->serial + ", firmware " +
                                                                tracker->firmware}
                  : CheckFinding{CheckFinding::Level::Failure, "tracker: " + tracker.error().detail}};
}

}  // namespace truepose::daemon
