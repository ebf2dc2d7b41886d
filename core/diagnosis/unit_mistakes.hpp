#pragma once

#include <span>
#include <vector>

#include "core/diagnosis/mistakes.hpp"

namespace truepose {

/// Units other than mm and deg, those of each file in the order of their fixes.
struct UnitMistakes {
  std::vector<Mistake> robot, measurements;
};

/// Those that the magnitudes show. Angles are in rad where each is less than a revolution of it. Lengths of
/// the robot file are in m or inches where the arm reaches next to nowhere. Points are where the arm, with
/// the other units converted, moves its flange many times as far.
///
/// A magnitude suggests a unit: the points then decide.
UnitMistakes units_by_magnitude(const RobotModel& arm, std::span<const Measurement> points);

/// All that measurements may have.
std::vector<Mistake> measurement_unit_mistakes(const RobotModel& arm);

/// Farther the flange is not from the base, whatever the revolute joints do.
double reach_mm(const RobotModel& robot);

/// Whether an arm reaches next to nowhere, as one whose lengths are in metres.
bool has_no_reach(const RobotModel& robot);

}  // namespace truepose
