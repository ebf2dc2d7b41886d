#pragma once

#include <cstdint>
#include <vector>

#include "tools/sim/motion/motion_planner.hpp"

namespace truepose::sim {

/// The switching points of the motions that an arm makes, as time continues.
class SwitchingPoints {
 public:
  /// The arm is in a motion. What it has come to is switched, or waits for its delay.
  /// @param into  since the motion's beginning
  /// @param blended_in, blended_out  how long it overlaps with the motions before and behind it
  /// @param rate  at which time passes on the path
  void visit(PlannedMotion& motion, Seconds into, Seconds blended_in, Seconds blended_out, double rate);
  /// A motion has ended. What lies behind its end goes over to the next; all else is switched.
  /// @param next  none where the arm stands
  void leave(PlannedMotion& motion, PlannedMotion* next);
  /// Delays continue, whatever the arm does.
  void pass(Seconds time);
  bool is_waiting() const { return !delayed_.empty(); }
  /// What was switched since this was last asked.
  std::vector<std::uint64_t> take();

 private:
  struct Delayed {
    std::uint64_t number = 0;
    Seconds left{0};
  };
  void come_to(const PlannedSwitch& point);

  std::vector<Delayed> delayed_;
  std::vector<std::uint64_t> switched_;
};

}  // namespace truepose::sim
