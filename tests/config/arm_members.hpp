#pragma once

#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"
#include "tests/members.hpp"

namespace truepose {

template <>
inline constexpr int kMembers<RobotModel> = 10;
template <>
inline constexpr int kMembers<Joint> = 11;
template <>
inline constexpr int kMembers<JointCoupling> = 3;
template <>
inline constexpr int kMembers<LinkMass> = 2;
template <>
inline constexpr int kMembers<DeviationTerm> = 4;
template <>
inline constexpr int kMembers<TrackerNoiseModel> = 4;

}  // namespace truepose
