#pragma once

#include <vector>

#include "core/simulate/joint_motion.hpp"

namespace truepose::sim {

/// A motion of all axes through points, from standstill to standstill: between two points a cubic in time
/// that leaves neither's range, with no jump of speed at them.
class JointSpline {
 public:
  struct Leg {
    JointVector to;
    Seconds duration{0};
  };
  JointSpline(const JointVector& from, const std::vector<Leg>& legs);

  Seconds duration() const { return Seconds{times_s_.back()}; }
  /// @param leg  from 0. @return when it ends
  Seconds end_of(std::size_t leg) const { return Seconds{times_s_[leg + 1]}; }
  JointVector position(Seconds t) const;

 private:
  std::vector<double> times_s_;
  std::vector<JointVector> points_, speeds_;
};

}  // namespace truepose::sim
