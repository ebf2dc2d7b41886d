#pragma once

#include <Eigen/Core>
#include <boost/json/value.hpp>
#include <cstdint>
#include <exception>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

#include "core/math/refraction.hpp"
#include "drivers/robot.hpp"
#include "drivers/tracker.hpp"

/// What is asked of the drivers of robot and tracker and what they answer, as the texts of records: JSON.
namespace truepose::daemon {

/// The calls of drivers::Robot and drivers::Tracker.
enum class Asked : std::uint8_t {
  Connect,
  State,
  Look,
  Move,
  StartStreamProgram,
  Stop,
  Aim,
  Measure,
  TurnOver,
  Check,
  Disconnect,  // these two are done at once, and have no outcome
  AverageOver,
};
constexpr bool has_outcome(Asked asked) { return asked != Asked::Disconnect && asked != Asked::AverageOver; }
std::string_view name(Asked asked);

/// One call with its arguments.
struct DriverCall {
  struct Aim {
    Eigen::Vector3d p_W_mm{0, 0, 0};
    double search_radius_mm = 0;
  };
  std::uint64_t number = 0;  ///< counts the calls of this driver
  Asked asked = Asked::Connect;
  drivers::TimePoint deadline{};  ///< of those that have an outcome
  drivers::MoveCommand move{};    ///< of a move
  Aim aim{};                      ///< of an aim
  drivers::Duration average{};    ///< of AverageOver
};
std::string text(const DriverCall& call);
std::expected<DriverCall, std::string> read_call(std::string_view text);

/// Of every outcome; the answer, or the driver's error, stands beside it.
struct OutcomeHead {
  std::uint64_t call = 0;  ///< its number
  bool cancelled = false;  ///< by who had made it: there is neither answer nor error
};
std::expected<OutcomeHead, std::string> read_outcome(std::string_view text);

std::string outcome_text(std::uint64_t call, const std::expected<void, drivers::RobotError>& outcome);
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::RobotIdentity, drivers::RobotError>& outcome);
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::RobotState, drivers::RobotError>& outcome);
std::string outcome_text(std::uint64_t call, const std::expected<JointVector, drivers::RobotError>& outcome);
std::string outcome_text(std::uint64_t call, const std::expected<void, drivers::TrackerError>& outcome);
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::TrackerIdentity, drivers::TrackerError>& outcome);
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::SmrPoint, drivers::TrackerError>& outcome);
/// Of a call that was left by an exception.
std::string outcome_text(std::uint64_t call, std::exception_ptr thrown);

/// What a tracker's driver is told when it asks for the air; or why nothing is known.
using ToldAir = std::expected<Air, std::string>;
std::string text(const ToldAir& air);
/// Error: one sentence on why the text is none.
std::expected<ToldAir, std::string> read_air(std::string_view text);

}  // namespace truepose::daemon
