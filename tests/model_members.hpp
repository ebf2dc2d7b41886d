#pragma once

#include "core/arm/robot_model.hpp"
#include "core/calibrate/calibration.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/quality/calibration_verdict.hpp"
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
template <>
inline constexpr int kMembers<Reflector> = 2;
template <>
inline constexpr int kMembers<IdentifiedParameter> = 6;
template <>
inline constexpr int kMembers<BasePose> = 2;
template <>
inline constexpr int kMembers<CalibrationVerdict> = 1;
template <>
inline constexpr int kMembers<MeasurementNoise> = 2;
template <>
inline constexpr int kMembers<Finding> = 4;

}  // namespace truepose
