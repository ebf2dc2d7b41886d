#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/identify/measurement.hpp"

namespace truepose {

/// A mistake that robot files or measurement files may contain, and how to undo it.
struct Mistake {
  std::string what;  ///< "joint 3 turns the other way: with sign -1"
  std::function<void(RobotModel&, std::vector<Measurement>&)> mend;
};

/// Each joint turning the other way.
std::vector<Mistake> sign_mistakes(const RobotModel& robot);

/// One thing wrong, the most usual first: a joint's sign, a zero off by a right angle or two, an alpha's
/// sign, a and d swapped, two joint columns swapped, units.
std::vector<Mistake> single_mistakes(const RobotModel& robot);

/// Several things wrong: signs of two and more joints (of two alone beyond eight joints), a sign and a zero
/// of one joint. The fewest first.
std::vector<Mistake> combined_mistakes(const RobotModel& robot);

}  // namespace truepose
