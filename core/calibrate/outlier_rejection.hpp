#pragma once

#include <span>
#include <vector>

#include "core/calibrate/calibrate_options.hpp"
#include "core/calibrate/calibration.hpp"

namespace truepose {

/// Points of both sets that no noise explains: beyond six standard deviations, those of the prediction
/// included, under the richest model that the points to identify support. Where these are many, and their
/// errors have longer tails, as far beyond as hardly one of so many is by chance.
///
/// The points are judged by the geometry first. Where that calls any of them gross, joint deviations are
/// looked for, whatever the options say: gears, bearings and loads move good points farther than a geometric
/// model allows for. Where the options leave deviations out, both models have to call it gross. Poses that
/// all their reflectors show off in the same way contradict the model and not the other points: they stay in
/// where a model fitted with them explains them. Only the points to identify have a say in the model; a
/// redescending loss keeps outliers from it.
///
/// @param data  points that calibrate() accepts
/// @return in the order of the points; nothing if the points are too few to test each against a model of the
/// others
std::vector<RejectedPoint> find_outliers(const RobotModel& nominal, const MeasurementData& data,
                                         const CalibrateOptions& options);

/// The data without these points.
MeasurementData without(std::span<const RejectedPoint> points, const MeasurementData& data);

}  // namespace truepose
