#pragma once

#include <string>

#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges where the arm is: each axis within its software limits, and at rest unless a campaign, the stream
/// or a program of production moves it.
class AxisJudge {
 public:
  AxisJudge(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  /// Where the controller says the arm is, in a cycle of RSI.
  void see(const RsiCycle& cycle);
  /// Looks at the arm, once a second.
  /// @param state  of the cell; empty: not known
  void look(const std::string& state);

 private:
  void judge_limits(const JointVector& q_rad, const std::string& where);
  void judge_rest(const JointVector& q_rad, const std::string& state);

  Cell& cell_;
  SoakLog& log_;
  std::string state_;  // of the last look
  JointVector q_rad_;  // of the last look; empty: none
  drivers::TimePoint last_cycle_{}, may_move_until_{};
};

}  // namespace truepose::world
