#pragma once

#include <array>
#include <cstdint>

#include "core/arm/joint_deviation.hpp"
#include "core/arm/robot_model.hpp"
#include "core/math/units.hpp"

namespace truepose::daemon {

/// From which side each axis came to where it is, by the motion that the program commands: for the play of
/// its gear. Once shown a direction lasts until the axis has gone back by more than kShown_rad.
class ApproachWatch {
 public:
  /// Above the last decimal of a command and the corrections of an axis at rest; far below any motion.
  static constexpr double kShown_rad = 0.01 * kRadPerDeg;

  /// Nothing is known of any axis.
  void restart() noexcept;
  /// No allocation. @return whether a direction has become another
  bool take(const JointVector& commanded) noexcept;
  /// 1 upwards, -1 downwards, 0 not known yet; a view of the watch itself.
  Approach directions() const noexcept { return directions_; }

 private:
  struct Range {
    double min, max;  // of where it went since it last turned, as far as that matters
  };
  std::array<Range, 6> ranges_{};
  std::array<std::int8_t, 6> directions_{};
  bool begun_ = false;
};

}  // namespace truepose::daemon
