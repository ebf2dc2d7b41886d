#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/arm/joint_deviation.hpp"
#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Pose X_WB of the robot base in the tracker frame: R = Rz(rz) Ry(ry) Rx(rx). mm, rad.
struct BasePose {
  Eigen::Vector3d p_mm{0, 0, 0};
  Eigen::Vector3d rxyz_rad{0, 0, 0};  ///< (rx, ry, rz)

  Eigen::Isometry3d isometry() const;
  static BasePose of(const Eigen::Isometry3d& X_WB);
};

struct Reflector {
  std::string name;
  Eigen::Vector3d p_FS_mm{0, 0, 0};  ///< centre of the reflector in the flange frame
};

/// A robot as the tracker sees it: the arm, where it stands, and the reflectors on its flange.
struct CalibratedCell {
  RobotModel robot;
  BasePose base;
  std::vector<Reflector> reflectors;
  std::vector<BasePose> further_bases;  ///< where the tracker measured from more stations than one

  int station_count() const { return 1 + static_cast<int>(further_bases.size()); }
  /// The base as station 0 (`base`), 1, .. sees it.
  const BasePose& base_at(int station) const {
    return station == 0 ? base : further_bases[static_cast<std::size_t>(station - 1)];
  }
  BasePose& base_at(int station) {
    return station == 0 ? base : further_bases[static_cast<std::size_t>(station - 1)];
  }
  /// Pose of a station's tracker in the frame of the first station's; the identity for the first.
  Eigen::Isometry3d station_pose(int station) const;

  /// Where the tracker should see reflector `smr` with the encoders at `q`: p_WS, mm, from the first station.
  Eigen::Vector3d predict(const JointVector& q, int smr, Approach approach = {}) const;
  /// The same at a point that was measured, with what the flange carried there.
  Eigen::Vector3d predict(const Measurement& point) const;
};

/// Order of a cell's parameters in vectors and Jacobians: the base as each station sees it (3 translations in
/// mm, 3 small rotations about the tracker's axes in rad), 3 coordinates of each reflector (mm), then a,
/// alpha, d, theta, beta of each link (mm, rad), then the coefficient of each deviation term (rad or mm per
/// unit of its basis).
///
/// The base turns by rotation vectors and not by its printed Euler angles, so that no placement is near a
/// singularity.
struct ParameterLayout {
  static constexpr int kBase = 6;
  static constexpr int kReflector = 3;
  static constexpr int kLink = 5;
  enum LinkEntry { kA, kAlpha, kD, kTheta, kBeta };  ///< of a link's parameters

  int reflectors = 0;
  int joints = 0;
  int deviations = 0;
  int stations = 1;

  static ParameterLayout of(const CalibratedCell& cell);

  int base(int station) const { return kBase * station; }
  int reflector(int k) const { return kBase * stations + kReflector * k; }
  int link(int i) const { return reflector(reflectors) + kLink * i; }
  int deviation(int t) const { return link(joints) + t; }
  int size() const { return deviation(deviations); }
};

/// The first parameters of a layout: 0 .. count - 1.
std::vector<int> first_parameters(int count);

/// The parameter that is the zero of a joint: theta, or d where it moves along.
int zero_parameter(const RobotModel& robot, const ParameterLayout& layout, int joint);

/// "base.x".."base.z", "base.rx".."base.rz", the same of "base2" from a second station.., "smr.NAME.x"..,
/// "link1.a", .alpha, .d, .theta, .beta.., and deviation_name() of each term.
std::vector<std::string> parameter_names(const CalibratedCell& cell);

/// Values in the layout's order, the base's rotation as rx, ry, rz. mm, rad.
Eigen::VectorXd parameter_values(const CalibratedCell& cell);

/// Moves every parameter by `step` (layout order): R_base turns to exp(step.rotation) R_base. Does not
/// allocate.
void move_by(CalibratedCell& cell, const Eigen::VectorXd& step);
/// The cell so moved.
CalibratedCell moved(const CalibratedCell& cell, const Eigen::VectorXd& step);

}  // namespace truepose
