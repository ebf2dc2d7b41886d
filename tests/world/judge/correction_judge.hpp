#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tests/world/cell.hpp"
#include "tests/world/judge/arm.hpp"
#include "tests/world/rsi_cable.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges at the RSI cable whether a program is corrected by the active model: its flange stands where the
/// program wants it, as far as the model goes. The model is one of the arm that is there, and
/// the daemon's robot file is that arm's.
class CorrectionJudge {
 public:
  CorrectionJudge(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  /// The stream was armed: asks which model is active.
  boost::asio::awaitable<void> armed(Client& client);
  /// Another model may be active.
  void forget() { model_.reset(); }
  void see(const RsiCycle& cycle);

  std::uint64_t compared = 0;
  double largest_error_mm = 0;

 private:
  void judge(std::string_view reply);
  void judge_robot_file(std::string_view reply);

  Cell& cell_;
  SoakLog& log_;
  const RobotModel& nominal_ = cell_.scenario.nominal;
  std::optional<Arm> model_;  // active for sure
  std::string serial_;        // of its arm
  std::uint64_t session_ = 0;
  int cycles_ = 0;                               // of the session, answered in a row and undisturbed
  int at_rest_ = 0;                              // of these, since the program moved the arm
  std::optional<std::array<double, 6>> wanted_;  // by the program in the last cycle
};

}  // namespace truepose::world
