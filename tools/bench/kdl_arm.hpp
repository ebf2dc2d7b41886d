#pragma once

#include <kdl/chain.hpp>

#include "core/arm/forward.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::bench {

/// KDL works in metres here, as its users do: its solvers weigh a metre like a radian.
inline constexpr double kMetres = 1e-3;

inline KDL::Frame kdl_frame(const Eigen::Isometry3d& X) {
  const auto& R = X.linear();
  const auto& p = X.translation();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          KDL::Vector(p.x() * kMetres, p.y() * kMetres, p.z() * kMetres)};
}

inline KDL::JntArray kdl_joints(const JointVector& q) {
  KDL::JntArray out(static_cast<unsigned>(q.size()));
  out.data = q;
  return out;
}

/// An arm of revolute joints. A KDL segment turns first and carries its link after, so link i + 1 is the tip
/// of segment i; the first link goes into the first joint's axis, which spares KDL a fixed segment.
inline KDL::Chain kdl_chain(const RobotModel& robot) {
  KDL::Chain chain;
  const KDL::Frame base = kdl_frame(link_transform(robot.joints[0], 0));
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const bool last = i + 1 == robot.joints.size();
    const KDL::Frame tip = kdl_frame(last ? robot.X_flange : link_transform(robot.joints[i + 1], 0));
    const double sign = robot.joints[i].sign;
    if (i == 0) {
      chain.addSegment(
          KDL::Segment(KDL::Joint(base.p, base.M.UnitZ() * sign, KDL::Joint::RotAxis), base * tip));
    } else {
      chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ, sign), tip));
    }
  }
  return chain;
}

}  // namespace truepose::bench
