#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"

namespace truepose {

/// Order of a cell's parameters in vectors and Jacobians: base (3 translations in mm, 3 small rotations about
/// the tracker's axes in rad), 3 coordinates of each reflector (mm), then a, alpha, d, theta, beta of each
/// link (mm, rad), then the coefficient of each deviation term (rad or mm per unit of its basis).
///
/// The base turns by rotation vectors and not by its printed Euler angles, so that no placement is near a
/// singularity.
struct ParameterLayout {
  static constexpr int kBase = 6;
  static constexpr int kReflector = 3;
  static constexpr int kLink = 5;

  int reflectors = 0;
  int joints = 0;
  int deviations = 0;

  static ParameterLayout of(const CalibratedCell& cell);

  int reflector(int k) const { return kBase + kReflector * k; }
  int link(int i) const { return kBase + kReflector * reflectors + kLink * i; }
  int deviation(int t) const { return link(joints) + t; }
  int size() const { return deviation(deviations); }
};

/// "base.x".."base.z", "base.rx".."base.rz", "smr.NAME.x".., "link1.a", .alpha, .d, .theta, .beta.., and
/// deviation_name() of each term.
std::vector<std::string> parameter_names(const CalibratedCell& cell);

/// Values in the layout's order, the base's rotation as rx, ry, rz. mm, rad.
Eigen::VectorXd parameter_values(const CalibratedCell& cell);

/// Moves every parameter by `step` (layout order): R_base turns to exp(step.rotation) R_base. Does not
/// allocate.
void move_by(CalibratedCell& cell, const Eigen::VectorXd& step);
/// The cell so moved.
CalibratedCell moved(const CalibratedCell& cell, const Eigen::VectorXd& step);

}  // namespace truepose
