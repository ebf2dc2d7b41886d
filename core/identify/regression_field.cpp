#include "core/identify/regression_field.hpp"

#include <algorithm>
#include <cmath>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/units.hpp"

namespace truepose {
namespace {

constexpr int kReflectorsForTurn = 3;

using Features = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 4 * kMaxJoints, 1>;

Features features_of(std::span<const JointType> joints, const JointVector& q) {
  const int orders = 4 * q.size() <= kMaxFeatures ? 2 : 1;
  Features x(4 * q.size());
  Eigen::Index n = 0;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (joints[static_cast<std::size_t>(i)] == JointType::Prismatic) {
      x[n++] = kMetresPerMm * q[i];
      continue;
    }
    for (int order = 1; order <= orders; ++order) {
      x[n++] = std::cos(order * q[i]);
      x[n++] = std::sin(order * q[i]);
    }
  }
  x.conservativeResize(n);
  return x;
}

std::vector<JointType> types_of(const RobotModel& robot) {
  std::vector<JointType> types;
  for (const Joint& joint : robot.joints) types.push_back(joint.type);
  return types;
}

/// One reading of a pose: where the reflector was predicted, and by how much it stood elsewhere. Base frame,
/// mm.
struct Reading {
  Eigen::Vector3d p_B, off_B;
};

Eigen::Vector3d mean_off(std::span<const Reading> readings) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Reading& reading : readings) sum += reading.off_B;
  return sum / static_cast<double>(readings.size());
}

/// Displacement of the point p_B and turn about it that explain the readings best (least squares).
Eigen::Matrix<double, 6, 1> twist(std::span<const Reading> readings, const Eigen::Vector3d& p_B) {
  Eigen::MatrixXd A(3 * static_cast<Eigen::Index>(readings.size()), 6);
  Eigen::VectorXd b(A.rows());
  Eigen::Index row = 0;
  for (const Reading& reading : readings) {
    const Eigen::Vector3d lever = (reading.p_B - p_B) / kTurnLever_mm;
    A.block<3, 3>(row, 0).setIdentity();
    A.block<3, 3>(row, 3) << 0, lever.z(), -lever.y(), -lever.z(), 0, lever.x(), lever.y(), -lever.x(), 0;
    b.segment<3>(row) = reading.off_B;
    row += 3;
  }
  return smallest_solution(A, b, 1e-12);
}

}  // namespace

RegressionField::RegressionField(const RobotModel& robot, RegressorPtr regressor,
                                 const Eigen::Vector3d& p_F_mm)
    : joints_{types_of(robot)},
      regressor_{std::move(regressor)},
      targets_{regressor_->state().Y.cols()},
      p_F_mm_{p_F_mm} {}

Eigen::Isometry3d RegressionField::displaced(const JointVector& q,
                                             const Eigen::Isometry3d& X_BF) const noexcept {
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1> y(targets_);
  regressor_->predict(features_of(joints_, q), y);
  Eigen::Isometry3d X = X_BF;
  if (y.size() == 6) {
    X.linear() = rotation_by(y.tail<3>() / kTurnLever_mm) * X_BF.linear();
  }
  X.translation() = X_BF * p_F_mm_ + y.head<3>() - X.linear() * p_F_mm_;
  return X;
}

int field_features(const RobotModel& robot) {
  return static_cast<int>(features_of(types_of(robot), JointVector::Zero(robot.joint_count())).size());
}

FieldData field_data(const CalibratedCell& cell, std::span<const Measurement> points) {
  const std::vector<int> pose = pose_numbers(points);
  const int poses = count_poses(points);
  const Eigen::Isometry3d X_BW = inverse_of(cell.base.isometry());
  std::vector<std::vector<Reading>> readings(static_cast<std::size_t>(poses));
  std::vector<const Measurement*> of_pose(static_cast<std::size_t>(poses));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Measurement& m = points[i];
    const Eigen::Vector3d predicted = cell.predict(m.q, m.smr, m.direction);
    readings[static_cast<std::size_t>(pose[i])].push_back(
        {X_BW * predicted, X_BW.linear() * (m.p_WS_mm - predicted)});
    of_pose[static_cast<std::size_t>(pose[i])] = &m;
  }
  const bool turns =
      std::ranges::all_of(readings, [](const auto& of_one) { return of_one.size() >= kReflectorsForTurn; });

  FieldData data;
  for (const Reflector& reflector : cell.reflectors) {
    data.p_F_mm += reflector.p_FS_mm / static_cast<double>(cell.reflectors.size());
  }
  const std::vector<JointType> joints = types_of(cell.robot);
  const Eigen::Index features = features_of(joints, of_pose.front()->q).size();
  data.regression.X.resize(poses, features);
  data.regression.Y.resize(poses, turns ? 6 : 3);
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Measurement& m = *of_pose[k];
    data.regression.X.row(row) = features_of(joints, m.q).transpose();
    if (turns) {
      const Eigen::Vector3d p_B = forward_kinematics(cell.robot, m.q, m.direction) * data.p_F_mm;
      data.regression.Y.row(row) = twist(readings[k], p_B).transpose();
    } else {
      data.regression.Y.row(row) = mean_off(readings[k]).transpose();
    }
  }
  return data;
}

}  // namespace truepose
