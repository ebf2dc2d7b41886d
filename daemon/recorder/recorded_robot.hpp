#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <expected>
#include <utility>

#include "daemon/recorder/driver_call.hpp"
#include "drivers/kuka/eki_robot.hpp"
#include "drivers/wire_tap.hpp"

namespace truepose::daemon {

/// A robot's driver of which a tap hears what it is asked for and what comes of that; and how it was made and
/// what it remembers, wherever it has no connection or makes it anew, so that a replay can begin there.
class RecordedRobot final : public drivers::Robot {
 public:
  template <typename T>
  using Outcome = boost::asio::awaitable<std::expected<T, drivers::RobotError>>;

  /// @param robot  outlives it
  /// @param calls  number of the call before the first
  RecordedRobot(drivers::KukaEkiRobot& robot, drivers::WireTap tap, std::uint64_t calls = 0)
      : robot_{robot}, tap_{std::move(tap)}, calls_{calls} {}

  Outcome<drivers::RobotIdentity> connect(drivers::TimePoint deadline) override;
  Outcome<drivers::RobotState> state(drivers::TimePoint deadline) override;
  Outcome<drivers::RobotState> look(drivers::TimePoint deadline) override;
  Outcome<JointVector> move(drivers::MoveCommand command, drivers::TimePoint deadline) override;
  Outcome<void> start_stream_program(drivers::TimePoint deadline) override;
  Outcome<void> stop(drivers::TimePoint deadline) override;
  void disconnect() noexcept override;

 private:
  std::uint64_t begin(DriverCall call);

  drivers::KukaEkiRobot& robot_;
  drivers::WireTap tap_;
  std::uint64_t calls_;
};

}  // namespace truepose::daemon
