#pragma once

#include <vector>

#include "core/simulate/joint_motion.hpp"

namespace truepose::sim {

/// How fast a part of a path may be gone along.
struct SpeedLimit {
  double length_mm = 0;
  double speed_mm_s = 0, acceleration_mm_s2 = 0;
  bool stops = false;  ///< at its end
};

/// The fastest way along a path from standstill to standstill: a trapezoid of speed on each part, and no jump
/// of speed where parts meet.
class SpeedProfile {
 public:
  explicit SpeedProfile(const std::vector<SpeedLimit>& parts);

  Seconds duration() const;
  double length_mm() const;
  /// The way covered at a time, from 0 to length_mm().
  double covered_mm(Seconds t) const;
  /// When so much is covered: from 0 to duration().
  Seconds time_at(double mm) const;

 private:
  /// Evenly faster or slower.
  struct Phase {
    double begins_s = 0, begins_mm = 0;
    double speed_mm_s = 0, acceleration_mm_s2 = 0;
    double lasts_s = 0;
    double end_mm() const {
      return begins_mm + speed_mm_s * lasts_s + acceleration_mm_s2 * lasts_s * lasts_s / 2;
    }
  };
  void add(double from_mm_s, double to_mm_s, const SpeedLimit& part);
  void add_phase(double speed_mm_s, double acceleration_mm_s2, double lasts_s);

  std::vector<Phase> phases_;
};

}  // namespace truepose::sim
