#pragma once

#include <limits>
#include <span>

#include "core/change/time_evidence.hpp"

namespace truepose {

/// What one joint errs with its own angle, as an explanation of residuals.
struct JointErrors {
  int joint = 0;  ///< from 0
  double criterion =
      std::numeric_limits<double>::infinity();  ///< akaike_criterion() of it; smaller is likelier
};

/// Every entry of a link free to go round with its joint once, or once and twice a turn, as eccentric gears
/// and bearings out of true do, with all parameters left free; of a rail by as many waves over its travel. Of
/// all joints the one that explains the residuals best.
///
/// @param points  those of the evidence
JointErrors likeliest_joint_errors(const CalibratedCell& cell, const TimeEvidence& evidence,
                                   std::span<const Measurement> points);

/// The same criterion of an arm that was cold at the first point and warmed up by an exponential: the zeros
/// of its joints and all its lengths change in that way.
///
/// @param points  in the order in which they were measured
double warm_up_criterion(const CalibratedCell& cell, const TimeEvidence& evidence,
                         std::span<const Measurement> points);

}  // namespace truepose
