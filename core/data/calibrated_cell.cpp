#include "core/data/calibrated_cell.hpp"

#include <numeric>

#include "core/arm/forward.hpp"
#include "core/arm/joint_deviation.hpp"
#include "core/math/angles.hpp"

namespace truepose {

Eigen::Isometry3d BasePose::isometry() const {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = rotation_zyx(rxyz_rad.z(), rxyz_rad.y(), rxyz_rad.x());
  X_WB.translation() = p_mm;
  return X_WB;
}

BasePose BasePose::of(const Eigen::Isometry3d& X_WB) {
  return {X_WB.translation(), angles_zyx(X_WB.linear())};
}

Eigen::Isometry3d CalibratedCell::station_pose(int station) const {
  if (station == 0) return Eigen::Isometry3d::Identity();
  return base.isometry() * inverse_of(base_at(station).isometry());
}

Eigen::Vector3d CalibratedCell::predict(const JointVector& q, int smr, Approach approach) const {
  const Eigen::Isometry3d X_BF = forward_kinematics(robot, q, approach);
  return base.isometry() * (X_BF * reflectors[static_cast<std::size_t>(smr)].p_FS_mm);
}

Eigen::Vector3d CalibratedCell::predict(const Measurement& point) const {
  if (!point.payload) return predict(point.q, point.smr, point.direction);
  CalibratedCell loaded = *this;
  loaded.robot.payload = point.payload;
  return loaded.predict(point.q, point.smr, point.direction);
}

ParameterLayout ParameterLayout::of(const CalibratedCell& cell) {
  return {.reflectors = static_cast<int>(cell.reflectors.size()),
          .joints = cell.robot.joint_count(),
          .deviations = static_cast<int>(cell.robot.deviation.size()),
          .stations = cell.station_count()};
}

std::vector<int> first_parameters(int count) {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

int zero_parameter(const RobotModel& robot, const ParameterLayout& layout, int joint) {
  constexpr int kD = 2, kTheta = 3;
  const bool turns = robot.joints[static_cast<std::size_t>(joint)].type == JointType::Revolute;
  return layout.link(joint) + (turns ? kTheta : kD);
}

std::vector<std::string> parameter_names(const CalibratedCell& cell) {
  std::vector<std::string> names;
  for (int s = 1; s <= cell.station_count(); ++s) {
    const std::string base = s == 1 ? "base" : "base" + std::to_string(s);
    for (const char* entry : {".x", ".y", ".z", ".rx", ".ry", ".rz"}) names.push_back(base + entry);
  }
  for (const Reflector& reflector : cell.reflectors) {
    for (const char* axis : {".x", ".y", ".z"}) names.push_back("smr." + reflector.name + axis);
  }
  for (int i = 1; i <= cell.robot.joint_count(); ++i) {
    for (const char* entry : {".a", ".alpha", ".d", ".theta", ".beta"}) {
      names.push_back("link" + std::to_string(i) + entry);
    }
  }
  for (const DeviationTerm& term : cell.robot.deviation) names.push_back(deviation_name(term));
  return names;
}

Eigen::VectorXd parameter_values(const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  Eigen::VectorXd values(layout.size());
  for (int s = 0; s < layout.stations; ++s)
    values.segment<6>(layout.base(s)) << cell.base_at(s).p_mm, cell.base_at(s).rxyz_rad;
  for (int k = 0; k < layout.reflectors; ++k) {
    values.segment<3>(layout.reflector(k)) = cell.reflectors[static_cast<std::size_t>(k)].p_FS_mm;
  }
  for (int i = 0; i < layout.joints; ++i) {
    const Joint& joint = cell.robot.joints[static_cast<std::size_t>(i)];
    values.segment<5>(layout.link(i)) << joint.a_mm, joint.alpha_rad, joint.d_mm, joint.theta_rad,
        joint.beta_rad;
  }
  for (int t = 0; t < layout.deviations; ++t) {
    values[layout.deviation(t)] = cell.robot.deviation[static_cast<std::size_t>(t)].coefficient;
  }
  return values;
}

void move_by(CalibratedCell& cell, const Eigen::VectorXd& step) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  for (int s = 0; s < layout.stations; ++s) {
    Eigen::Isometry3d X_WB = cell.base_at(s).isometry();
    X_WB.translation() += step.segment<3>(layout.base(s));
    X_WB.linear() = rotation_by(step.segment<3>(layout.base(s) + 3)) * X_WB.linear();
    cell.base_at(s) = BasePose::of(X_WB);
  }
  for (int k = 0; k < layout.reflectors; ++k) {
    cell.reflectors[static_cast<std::size_t>(k)].p_FS_mm += step.segment<3>(layout.reflector(k));
  }
  for (int i = 0; i < layout.joints; ++i) {
    Joint& joint = cell.robot.joints[static_cast<std::size_t>(i)];
    const auto d = step.segment<5>(layout.link(i));
    joint.a_mm += d[0];
    joint.alpha_rad += d[1];
    joint.d_mm += d[2];
    joint.theta_rad += d[3];
    joint.beta_rad += d[4];
  }
  for (int t = 0; t < layout.deviations; ++t) {
    cell.robot.deviation[static_cast<std::size_t>(t)].coefficient += step[layout.deviation(t)];
  }
}

CalibratedCell moved(const CalibratedCell& cell, const Eigen::VectorXd& step) {
  CalibratedCell out = cell;
  move_by(out, step);
  return out;
}

}  // namespace truepose
