#pragma once

#include "config/model_file.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose {

/// An arm whose truth is known, as if it had been calibrated without an error.
/// @param noise_mm  of a reading, and of where the arm repeats to
inline config::ModelFile known_model(const RobotModel& nominal, double noise_mm) {
  config::ModelFile model{.name = nominal.name,
                          .created = "2026-01-02T03:04:05Z",
                          .cell = {.robot = with_published_errors(nominal)}};
  model.cell.base = {{4000, 500, -300}, {0.01, -0.02, 2.1}};
  model.cell.reflectors = {{"1", {62, -48, 187}}};
  const int size = ParameterLayout::of(model.cell).size();
  model.covariance = Eigen::VectorXd::Constant(size, 1e-12).asDiagonal();
  model.noise = MeasurementNoise{.tracker = {.range_mm = noise_mm, .transverse_mm = noise_mm},
                                 .repeatability_mm = noise_mm};
  return model;
}

}  // namespace truepose
