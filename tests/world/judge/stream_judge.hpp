#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/world/rsi_cable.hpp"

namespace truepose::world {

/// Judges at the RSI cable what the stream promises, by the text of the replies alone.
class StreamJudge {
 public:
  /// @param max_step_deg  of the cell file
  explicit StreamJudge(double max_step_deg) : max_step_deg_{max_step_deg} {}

  void see(const RsiCycle& cycle);

  std::uint64_t cycles = 0, sessions = 0;
  double largest_step_deg = 0;
  double left_deg = 0;              ///< correction of an axis where a program closed RSI last
  std::vector<std::string> broken;  ///< promises, each with its session and cycle

 private:
  using Axes = std::array<double, 6>;

  struct Session {
    Axes sent_deg{};               ///< the last correction
    Axes moved_deg{}, held_deg{};  ///< the last that moved the arm, and that is held
    int ignored = 0;               ///< cycles in a row
  };

  void judge_effect(const RsiCycle& cycle, Session& session, const std::string& where);

  const double max_step_deg_;
  std::map<std::uint64_t, Session> sessions_;
};

}  // namespace truepose::world
