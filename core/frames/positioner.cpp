#include "core/frames/positioner.hpp"

#include <cmath>
#include <numbers>

#include "core/arm/forward.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

bool is_turntable(const RobotModel& robot) {
  return robot.joint_count() == 1 && robot.joints[0].type == JointType::Revolute;
}

/// The first axis' frame in the root, before the joint turns it.
Eigen::Isometry3d first_axis(const RobotModel& robot) {
  Joint joint = robot.joints[0];
  joint.theta_rad = joint.d_mm = 0;
  return link_transform(joint, 0);
}

/// A turn about z and a shift along it.
Eigen::Isometry3d screw(double turn_rad, double shift_mm) {
  return link_transform({.d_mm = shift_mm, .theta_rad = turn_rad}, 0);
}

/// The screw of the axis `X_axis` that brings a frame, which stands at X_in from there, nearest to `X_given`.
Eigen::Isometry3d nearest_screw(const Eigen::Isometry3d& X_axis, const Eigen::Isometry3d& X_in,
                                const Eigen::Isometry3d& X_given) {
  const Eigen::Matrix3d M = X_in.linear() * X_given.linear().transpose() * X_axis.linear();
  const double turn_rad = std::atan2(M(0, 1) - M(1, 0), M(0, 0) + M(1, 1));
  const Eigen::Vector3d left =
      inverse_of(X_axis) * X_given.translation() - (screw(turn_rad, 0) * X_in).translation();
  return screw(turn_rad, left.z());
}

/// The root in the arm's base, and what it leaves to the table.
PositionerRoot root_of(const CalibratedCell& arm, const CalibratedCell& table, const RobotModel& nominal,
                       const Eigen::Isometry3d& X_given) {
  const Eigen::Isometry3d X_BR = inverse_of(arm.base.isometry()) * table.base.isometry();
  if (!is_turntable(nominal)) return {.X_BR = X_BR};
  const Eigen::Isometry3d X_axis = X_BR * first_axis(table.robot);
  const Eigen::Isometry3d X_in = inverse_of(first_axis(nominal));
  const Eigen::Isometry3d X_screw = nearest_screw(X_axis, X_in, X_given);
  const Joint &drawn = nominal.joints[0], &known = table.robot.joints[0];
  const Eigen::Isometry3d X_back =
      screw(known.theta_rad - drawn.theta_rad, known.d_mm - drawn.d_mm) * inverse_of(X_screw);
  return {.X_BR = X_axis * X_screw * X_in,
          .X_to_model = inverse_of(nominal.X_flange) * X_back * table.robot.X_flange};
}

/// Derivative of a frame to the parameters of one of the two that are uncertain.
template <typename FrameOf>
Eigen::Matrix<double, 6, Eigen::Dynamic> derivative(const FrameOf& frame, const MeasuringCell& of) {
  constexpr double kStep = 1e-5;  // mm or rad
  Eigen::Matrix<double, 6, Eigen::Dynamic> D = Eigen::MatrixXd::Zero(6, of.covariance.cols());
  for (Eigen::Index k = 0; k < D.cols(); ++k) {
    if (!(of.covariance(k, k) > 0)) continue;
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(D.cols(), k);
    const Eigen::Isometry3d before = frame(moved(of.cell, -step)), after = frame(moved(of.cell, step));
    D.col(k) << after.translation() - before.translation(), turn_between(before.linear(), after.linear());
  }
  return D / (2 * kStep);
}

}  // namespace

PositionerRoot positioner_root(const MeasuringCell& arm, const MeasuringCell& table,
                               const RobotModel& nominal, const Eigen::Isometry3d& X_given) {
  PositionerRoot root = root_of(arm.cell, table.cell, nominal, X_given);
  const auto by_arm = [&](const CalibratedCell& cell) {
    return root_of(cell, table.cell, nominal, X_given).X_BR;
  };
  const auto by_table = [&](const CalibratedCell& cell) {
    return root_of(arm.cell, cell, nominal, X_given).X_BR;
  };
  root.covariance = congruence(derivative(by_arm, arm), arm.covariance) +
                    congruence(derivative(by_table, table), table.covariance);
  return root;
}

MeasuredFrame workpiece_frame(const MeasuredFrame& on_table, const MeasuringCell& arm,
                              const MeasuringCell& table, const RobotModel& nominal,
                              const Eigen::Isometry3d& X_given) {
  const auto by_arm = [&](const CalibratedCell& cell) {
    return root_of(cell, table.cell, nominal, X_given).X_to_model * on_table.X;
  };
  const auto by_table = [&](const CalibratedCell& cell) {
    return root_of(arm.cell, cell, nominal, X_given).X_to_model * on_table.X;
  };
  const Eigen::Isometry3d X_to_model = root_of(arm.cell, table.cell, nominal, X_given).X_to_model;
  PoseCovariance turned = PoseCovariance::Zero();
  turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = X_to_model.linear();
  MeasuredFrame frame = on_table;
  frame.X = X_to_model * on_table.X;
  frame.by_readings = congruence(turned, on_table.by_readings);
  frame.by_parameters = derivative(by_table, table) + times(turned, on_table.by_parameters);
  frame.covariance = frame.by_readings + congruence(frame.by_parameters, table.covariance) +
                     congruence(derivative(by_arm, arm), arm.covariance);
  return frame;
}

std::string why_turned(const Eigen::Isometry3d& X_BR, const RobotModel& arm, const RobotModel& nominal,
                       const std::optional<Eigen::Isometry3d>& X_given) {
  constexpr const char* kLook =
      ": look at the signs of its joints, and whether x, y and z of its points are swapped";
  if (X_given) {
    const double turn_rad = angle_between(X_given->linear(), X_BR.linear());
    if (turn_rad < std::numbers::pi / 2) return {};
    return formatted("the root stands turned by %.0f deg from where it was given", turn_rad * kDegPerRad) +
           kLook;
  }
  if ((X_BR.linear() * nominal.gravity_B).dot(arm.gravity_B) >= 0) return {};
  return std::string("the root stands on its head by `gravity` of both robot files") + kLook;
}

Eigen::Isometry3d table_in_base(const CalibratedCell& arm, const CalibratedCell& table,
                                const JointVector& q) {
  return inverse_of(arm.base.isometry()) * table.base.isometry() * forward_kinematics(table.robot, q);
}

}  // namespace truepose
