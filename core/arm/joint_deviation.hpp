#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// Direction in which each joint last moved: 1 upwards, -1 downwards, 0 unknown; empty = all unknown.
using Approach = std::span<const std::int8_t>;

/// Whether it is one of the three components of a link's first moment.
bool is_moment(DeviationBasis basis);

/// Values of the basis functions of `robot.deviation` at encoder positions q, one per term.
///
/// A term is a function of where its joint stands in the chain of links. Gravity torques are those at q
/// itself, without deviations. Does not allocate.
/// @param values  robot.deviation.size() of them
void deviation_basis(const RobotModel& robot, const JointVector& q, Approach approach,
                     std::span<double> values);

/// Where the joints truly stand when their encoders read q: the joints of the chain are off by the deviation
/// of every term, but for guides, which displace links; said as the controller would show it. Does not
/// allocate.
JointVector true_joints(const RobotModel& robot, const JointVector& q, Approach approach = {});

/// The same by the values of deviation_basis() there.
JointVector true_joints(const RobotModel& robot, const JointVector& q, std::span<const double> basis);

/// Whether the bases change with the parameters of the arm's own links, by which its torques are then
/// computed, and not with the encoders alone.
bool bases_follow_links(const RobotModel& robot);

/// Whether the term moves its joint or carriage along (mm), and does not turn it (rad).
bool moves_along(const RobotModel& robot, const DeviationTerm& term);

/// "joint2.sin1", "joint2.cos1", "joint2.gravity", "joint2.weight4" (weight7 = the flange of a six-axis arm),
/// "joint2.approach", "joint1.scale", "joint1.shiftx2", "joint1.turnz1".
std::string deviation_name(const DeviationTerm& term);

}  // namespace truepose
