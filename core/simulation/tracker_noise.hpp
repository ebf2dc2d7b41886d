#pragma once

#include <Eigen/Core>

#include "core/calibration/measurement_noise.hpp"
#include "core/random.hpp"

namespace truepose {

/// One reading of a point. mm, tracker frame (the tracker stands at its origin).
Eigen::Vector3d noisy_reading(const Eigen::Vector3d& p_true_mm, const TrackerNoiseModel& model,
                              Random& random);

}  // namespace truepose
