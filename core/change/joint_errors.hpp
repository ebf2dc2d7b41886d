#pragma once

#include <span>

#include "core/change/change_hypothesis.hpp"
#include "core/change/time_evidence.hpp"

namespace truepose {

/// What one joint errs with its own angle, as an explanation of residuals: its zero or every entry of its
/// link free to go round with the joint once, or once and twice a turn, as eccentric gears and bearings out
/// of true do, with all parameters left free; of a rail by as many waves over its travel. Of all joints the
/// one of the largest evidence.
///
/// @param points  those of the evidence
ChangeFound likeliest_joint_errors(const CalibratedCell& cell, const TimeEvidence& evidence,
                                   std::span<const Measurement> points);

/// The same of an arm that was cold at the first point and warmed up by an exponential: the zeros of its
/// joints and all its lengths change in that way.
///
/// @param points  in the order in which they were measured
ChangeFound warm_up(const CalibratedCell& cell, const TimeEvidence& evidence,
                    std::span<const Measurement> points);

}  // namespace truepose
