#include "core/calibration/measurement_model.hpp"

#include "core/calibration/parameters.hpp"
#include "core/kinematics/forward.hpp"

namespace truepose {
namespace {

/// A deviation moves its joint: the column of theta (prismatic: of d) times the value of its basis.
void fill_deviation_columns(const RobotModel& robot, const JointVector& q, Approach approach,
                            const ParameterLayout& layout, PointJacobian& J) {
  if (layout.deviations == 0) return;
  std::vector<double> basis(robot.deviation.size());
  deviation_basis(robot, q, approach, basis);
  for (std::size_t t = 0; t < basis.size(); ++t) {
    const int i = robot.deviation[t].joint;
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    const int column = layout.link(i) + (joint.type == JointType::Revolute ? 3 : 2);
    J.col(layout.deviation(static_cast<int>(t))) = joint.sign * basis[t] * J.col(column);
  }
}

}  // namespace

Eigen::Vector3d predict_with_jacobian(const CalibratedCell& cell, const JointVector& q, int smr,
                                      PointJacobian& J, Approach approach) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  const Eigen::Isometry3d X_WB = cell.base.isometry();
  LinkFrames X_B;
  link_frames(cell.robot.joints, true_joints(cell.robot, q, approach), X_B);
  const Eigen::Isometry3d X_WF = X_WB * X_B[cell.robot.joints.size()] * cell.robot.X_flange;
  const Eigen::Vector3d P = X_WF * cell.reflectors[static_cast<std::size_t>(smr)].p_FS_mm;

  J.setZero(3, layout.size());
  J.leftCols<3>().setIdentity();
  const Eigen::Vector3d lever = P - X_WB.translation();
  for (int k = 0; k < 3; ++k) J.col(3 + k) = Eigen::Vector3d::Unit(k).cross(lever);
  J.middleCols<3>(layout.reflector(smr)) = X_WF.linear();

  for (int i = 0; i < layout.joints; ++i) {
    const auto link = static_cast<std::size_t>(i);
    const Eigen::Isometry3d before = X_WB * X_B[link];
    const Eigen::Isometry3d after = X_WB * X_B[link + 1];
    const Eigen::Vector3d from_before = P - before.translation();
    const Eigen::Vector3d y = before.linear().col(1);
    const Eigen::Vector3d x =
        before.linear() * (Eigen::AngleAxisd(cell.robot.joints[link].beta_rad, Eigen::Vector3d::UnitY()) *
                           Eigen::Vector3d::UnitX());
    const Eigen::Vector3d z = after.linear().col(2);
    auto columns = J.middleCols<5>(layout.link(i));
    columns.col(0) = x;
    columns.col(1) = x.cross(from_before);
    columns.col(2) = z;
    columns.col(3) = z.cross(P - after.translation());
    columns.col(4) = y.cross(from_before);
  }
  fill_deviation_columns(cell.robot, q, approach, layout, J);
  return P;
}

Eigen::VectorXd residuals(const CalibratedCell& cell, std::span<const Measurement> points) {
  Eigen::VectorXd f(3 * static_cast<Eigen::Index>(points.size()));
  Eigen::Index row = 0;
  for (const Measurement& point : points) {
    f.segment<3>(row) = cell.predict(point.q, point.smr, point.direction) - point.p_WS_mm;
    row += 3;
  }
  return f;
}

void residuals_with_jacobian(const CalibratedCell& cell, std::span<const Measurement> points,
                             Eigen::VectorXd& f, Eigen::MatrixXd& J) {
  f.resize(3 * static_cast<Eigen::Index>(points.size()));
  J.resize(f.size(), ParameterLayout::of(cell).size());
  PointJacobian point_jacobian;
  Eigen::Index row = 0;
  for (const Measurement& point : points) {
    f.segment<3>(row) =
        predict_with_jacobian(cell, point.q, point.smr, point_jacobian, point.direction) - point.p_WS_mm;
    J.middleRows<3>(row) = point_jacobian;
    row += 3;
  }
}

}  // namespace truepose
