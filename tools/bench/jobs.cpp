#include "tools/bench/jobs.hpp"

#include <cmath>

#include "core/arm/forward.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose::bench {
namespace {

JointVector random_joints(const RobotModel& robot, Random& random) {
  JointVector q(robot.joint_count());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    q[i] = random.uniform(joint.min, joint.max);
  }
  return q;
}

/// Link 1 moves with the base, theta and d of link 6 with the reflector, d_3 with d_2 (its beta speaks for
/// the tilt), and the other betas with alpha and theta.
std::vector<int> separable(const ParameterLayout& layout) {
  std::vector<int> free;
  for (int k = 0; k < layout.link(0); ++k) free.push_back(k);
  enum { kA, kAlpha, kD, kTheta, kBeta };
  for (int link = 1; link < 6; ++link) {
    for (int entry = kA; entry <= kBeta; ++entry) {
      const bool third = link == 2, last = link == 5;
      if (entry == kBeta && !third) continue;
      if (entry == kD && (third || last)) continue;
      if (entry == kTheta && last) continue;
      free.push_back(layout.link(link) + entry);
    }
  }
  return free;
}

}  // namespace

RobotModel kr210(bool calibrated) {
  return calibrated ? with_published_errors(published_arm()) : published_arm();
}

std::vector<JointVector> joint_positions(int count) {
  const RobotModel robot = kr210(true);
  Random random{1};
  std::vector<JointVector> q;
  for (int k = 0; k < count; ++k) q.push_back(random_joints(robot, random));
  return q;
}

Identification identification(int points) {
  const Eigen::Vector3d p_WB(3500, -800, -150), turn(0.02, -0.01, 2.4), p_FS(40, -30, 120);
  const CalibratedCell truth{kr210(true), {p_WB, turn}, {{"1", p_FS}}};
  Identification job;
  job.start = {kr210(false),
               {p_WB + Eigen::Vector3d(3, -4, 2), turn + Eigen::Vector3d(2e-3, -1.5e-3, 3e-3)},
               {{"1", p_FS + Eigen::Vector3d(1, -0.8, 1.5)}}};
  Random random{2};
  for (int k = 0; k < points; ++k) {
    const JointVector q = random_joints(truth.robot, random);
    job.points.push_back({.q = q, .p_WS_mm = truth.predict(q, 0)});
  }
  job.free = separable(ParameterLayout::of(job.start));
  return job;
}

double rms_mm(const CalibratedCell& cell, const std::vector<Measurement>& points) {
  double sum = 0;
  for (const Measurement& point : points)
    sum += (cell.predict(point.q, point.smr) - point.p_WS_mm).squaredNorm();
  return std::sqrt(sum / static_cast<double>(points.size()));
}

const std::vector<InverseTarget>& inverse_targets() {
  static const std::vector<InverseTarget> targets = [] {
    constexpr int kTargets = 10000;
    constexpr double kOff = 5 * kRadPerDeg;
    const RobotModel robot = kr210(true);
    Random random{3};
    std::vector<InverseTarget> out;
    for (int k = 0; k < kTargets; ++k) {
      const JointVector q = random_joints(robot, random);
      JointVector seed = q;
      for (double& joint : seed) joint += random.uniform(-kOff, kOff);
      out.push_back({forward_kinematics(robot, q), seed});
    }
    return out;
  }();
  return targets;
}

}  // namespace truepose::bench
