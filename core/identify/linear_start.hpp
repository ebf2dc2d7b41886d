#pragma once

#include <span>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/measurement.hpp"

namespace truepose {

/// Where the base stands and where the reflectors sit, without any guess: one linear least-squares problem.
///
/// With c the measured point, (R_k, p_k) the nominal flange and R the base's rotation, R' c - s - R_k t = p_k
/// is linear in R' (9), s = R' P_base (3) and t of each reflector (3). R' is then projected onto the
/// rotations, and P_base and t are solved again with it. An estimate to iterate from; measurement noise and
/// link errors are not weighed.
///
/// @param arm     nominal arm
/// @param points  at least five poses of varying orientation
/// Source: method's paper's coarse stage, started as in section 4 of the method.
CalibratedCell linear_start(const RobotModel& arm, std::span<const std::string> smr_names,
                            std::span<const Measurement> points);

}  // namespace truepose
