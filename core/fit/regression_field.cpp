#include "core/fit/regression_field.hpp"

#include <algorithm>
#include <cmath>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/units.hpp"

namespace truepose {
namespace {

constexpr std::size_t kReflectorsForTurn = 3;
constexpr double kMostWithTurn = 0.8;  // of the poses

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

/// Displacement of a point at the lever by a turn about each axis.
Eigen::Matrix3d turn_columns(const Eigen::Vector3d& lever) {
  Eigen::Matrix3d columns;
  columns << 0, lever.z(), -lever.y(), -lever.z(), 0, lever.x(), lever.y(), -lever.x(), 0;
  return columns;
}

/// Displacement of the point p_B and turn about it that explain the readings best (least squares).
Eigen::Matrix<double, 6, 1> twist(std::span<const Reading> readings, const Eigen::Vector3d& p_B) {
  Eigen::MatrixXd A(3 * static_cast<Eigen::Index>(readings.size()), 6);
  Eigen::VectorXd b(A.rows());
  Eigen::Index row = 0;
  for (const Reading& reading : readings) {
    A.block<3, 3>(row, 0).setIdentity();
    A.block<3, 3>(row, 3) = turn_columns((reading.p_B - p_B) / kTurnLever_mm);
    b.segment<3>(row) = reading.off_B;
    row += 3;
  }
  return smallest_solution(A, b, 1e-12);
}

}  // namespace

RegressionField::RegressionField(const RobotModel& robot, RegressorPtr regressor,
                                 const Eigen::Vector3d& p_F_mm, double variance_factor)
    : joints_{types_of(robot)},
      regressor_{std::move(regressor)},
      targets_{regressor_->state().Y.cols()},
      p_F_mm_{p_F_mm},
      variance_factor_{variance_factor} {}

Eigen::Isometry3d RegressionField::displaced(const JointVector& q,
                                             const Eigen::Isometry3d& X_BF) const noexcept {
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1> y(targets_);
  regressor_->predict(features_of(joints_, q), y);
  return displaced_by(y, X_BF);
}

Eigen::Isometry3d RegressionField::displaced_by(const Eigen::Ref<const Eigen::VectorXd>& y,
                                                const Eigen::Isometry3d& X_BF) const noexcept {
  Eigen::Isometry3d X = X_BF;
  if (y.size() == 6) {
    X.linear() = rotation_by(y.tail<3>() / kTurnLever_mm) * X_BF.linear();
  }
  X.translation() = X_BF * p_F_mm_ + y.head<3>() - X.linear() * p_F_mm_;
  return X;
}

Eigen::Matrix3d RegressionField::covariance(const JointVector& q, const Eigen::Isometry3d& X_BF,
                                            const Eigen::Vector3d& p_F_mm) const {
  const Eigen::VectorXd variance = variance_factor_ * regressor_->variance(features_of(joints_, q));
  Eigen::Matrix3d C = variance.head<3>().asDiagonal();
  if (variance.size() == 3) return C;
  const Eigen::Vector3d lever = X_BF.linear() * (p_F_mm - p_F_mm_) / kTurnLever_mm;
  const Eigen::Matrix3d A = turn_columns(lever);
  return C + A * variance.tail<3>().asDiagonal() * A.transpose();
}

int field_features(const RobotModel& robot) {
  return static_cast<int>(features_of(types_of(robot), JointVector::Zero(robot.joint_count())).size());
}

std::vector<bool> makes_field(std::span<const Measurement> points) {
  const auto groups = pose_groups(points);
  const auto turns = [](const std::vector<std::size_t>& pose) { return pose.size() >= kReflectorsForTurn; };
  const std::ptrdiff_t with_turn = std::ranges::count_if(groups, turns);
  const bool most = static_cast<double>(with_turn) >= kMostWithTurn * static_cast<double>(groups.size());
  const std::size_t poses = most ? static_cast<std::size_t>(with_turn) : groups.size();
  const std::size_t kept = std::min(poses, kMostFieldPoses);
  std::vector<bool> makes(points.size());
  std::size_t k = 0;  // of those that may be kept
  for (const std::vector<std::size_t>& pose : groups) {
    if (most && !turns(pose)) continue;
    const bool keeps = (k + 1) * kept / poses > k * kept / poses;
    ++k;
    for (const std::size_t i : pose) makes[i] = keeps;
  }
  return makes;
}

FieldData field_data(const CalibratedCell& cell, std::span<const Measurement> points) {
  const std::vector<int> pose = pose_numbers(points);
  const int poses = count_poses(points);
  std::vector<Eigen::Isometry3d> X_WB, X_BW;  // of each station
  for (int s = 0; s < cell.station_count(); ++s) {
    X_WB.push_back(cell.base_at(s).isometry());
    X_BW.push_back(inverse_of(X_WB.back()));
  }
  LoadedArm arm(cell.robot);
  std::vector<std::vector<Reading>> readings(static_cast<std::size_t>(poses));
  std::vector<const Measurement*> of_pose(static_cast<std::size_t>(poses));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Measurement& m = points[i];
    const auto s = static_cast<std::size_t>(m.station);
    const Eigen::Vector3d predicted = X_WB[s] * (forward_kinematics(arm.at(m), m.q, m.direction) *
                                                 cell.reflectors[static_cast<std::size_t>(m.smr)].p_FS_mm);
    readings[static_cast<std::size_t>(pose[i])].push_back(
        {X_BW[s] * predicted, X_BW[s].linear() * (m.p_WS_mm - predicted)});
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
      const Eigen::Vector3d p_B = forward_kinematics(arm.at(m), m.q, m.direction) * data.p_F_mm;
      data.regression.Y.row(row) = twist(readings[k], p_B).transpose();
    } else {
      data.regression.Y.row(row) = mean_off(readings[k]).transpose();
    }
  }
  return data;
}

std::vector<Eigen::Vector3d> errors_with(const Eigen::MatrixXd& targets, const RegressionField& field,
                                         const CalibratedCell& without_field,
                                         std::span<const Measurement> points) {
  const std::vector<int> pose = pose_numbers(points);
  LoadedArm arm(without_field.robot);
  std::vector<Eigen::Vector3d> errors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Measurement& m = points[i];
    const Eigen::Isometry3d X_BF =
        field.displaced_by(targets.row(pose[i]).transpose(), forward_kinematics(arm.at(m), m.q, m.direction));
    const Eigen::Vector3d& p_FS_mm = without_field.reflectors[static_cast<std::size_t>(m.smr)].p_FS_mm;
    errors.push_back(without_field.base_at(m.station).isometry() * (X_BF * p_FS_mm) - m.p_WS_mm);
  }
  return errors;
}

}  // namespace truepose
