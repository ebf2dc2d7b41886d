#include <benchmark/benchmark.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "core/arm/arm_kernel.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/robot_model.hpp"
#include "core/math/angles.hpp"
#include "tools/bench/jobs.hpp"

namespace truepose::bench {
namespace {

/// KDL works in metres here, as its users do: its solvers weigh a metre like a radian.
constexpr double kMetres = 1e-3;

KDL::Frame kdl_frame(const Eigen::Isometry3d& X) {
  const auto& R = X.linear();
  const auto& p = X.translation();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          KDL::Vector(p.x() * kMetres, p.y() * kMetres, p.z() * kMetres)};
}

KDL::JntArray kdl_joints(const JointVector& q) {
  KDL::JntArray out(static_cast<unsigned>(q.size()));
  out.data = q;
  return out;
}

/// An arm of revolute joints. A KDL segment turns first and carries its link after, so link i + 1 is the tip
/// of segment i; the first link goes into the first joint's axis, which spares KDL a fixed segment.
KDL::Chain kdl_chain(const RobotModel& robot) {
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

// ---- Forward kinematics and Jacobian ----

constexpr int kPoses = 1024;

/// Runs `job` with one of kPoses joint positions after the other.
template <typename Joints, typename Job>
void for_each_pose(benchmark::State& state, const std::vector<Joints>& q, Job job) {
  std::size_t k = 0;
  for (auto _ : state) {
    job(q[k]);
    k = (k + 1) % q.size();
  }
}

std::vector<KDL::JntArray> kdl_positions() {
  std::vector<KDL::JntArray> out;
  for (const JointVector& q : joint_positions(kPoses)) out.push_back(kdl_joints(q));
  return out;
}

void forward_kdl(benchmark::State& state) {
  const KDL::Chain chain = kdl_chain(kr210(true));
  KDL::ChainFkSolverPos_recursive solver(chain);
  KDL::Frame X;
  for_each_pose(state, kdl_positions(), [&](const KDL::JntArray& q) {
    solver.JntToCart(q, X);
    benchmark::DoNotOptimize(X);
  });
}

void forward_truepose(benchmark::State& state) {
  const ArmKernel arm{kr210(true)};
  for_each_pose(state, joint_positions(kPoses),
                [&](const JointVector& q) { benchmark::DoNotOptimize(arm.forward(q)); });
}

void forward_batch_truepose(benchmark::State& state) {
  const ArmKernel arm{kr210(true)};
  const std::vector<JointVector> positions = joint_positions(kPoses);
  Eigen::ArrayXXd q(kPoses, 6);
  for (int k = 0; k < kPoses; ++k) q.row(k) = positions[static_cast<std::size_t>(k)].transpose();
  PoseColumns poses(kPoses, 12);
  while (state.KeepRunningBatch(kPoses)) {
    arm.forward(q, poses);
    benchmark::DoNotOptimize(poses.data());
    benchmark::ClobberMemory();
  }
}

void jacobian_kdl(benchmark::State& state) {
  const KDL::Chain chain = kdl_chain(kr210(true));
  KDL::ChainJntToJacSolver solver(chain);
  KDL::Jacobian J(6);
  for_each_pose(state, kdl_positions(), [&](const KDL::JntArray& q) {
    solver.JntToJac(q, J);
    benchmark::DoNotOptimize(J.data.data());
    benchmark::ClobberMemory();
  });
}

void jacobian_truepose(benchmark::State& state) {
  const ArmKernel arm{kr210(true)};
  PoseAndJacobian at;
  for_each_pose(state, joint_positions(kPoses), [&](const JointVector& q) {
    arm.forward_with_jacobian(q, at);
    benchmark::DoNotOptimize(at);
    benchmark::ClobberMemory();
  });
}

BENCHMARK(forward_kdl)->Name("forward/kdl");
BENCHMARK(forward_truepose)->Name("forward/truepose");
BENCHMARK(forward_batch_truepose)->Name("forward_batch/truepose");
BENCHMARK(jacobian_kdl)->Name("jacobian/kdl");
BENCHMARK(jacobian_truepose)->Name("jacobian/truepose");

// ---- The inverse ----

/// As KDL's own examples set them.
constexpr double kKdlTolerance = 1e-9;
constexpr unsigned kKdlIterations = 500;

/// Solves every target once and counts, outside the time taken, how many joints reach theirs within 1e-5 mm
/// and 1e-8 rad.
template <typename Solve>
void solve_targets(benchmark::State& state, Solve solve) {
  const std::vector<InverseTarget>& targets = inverse_targets();
  std::vector<JointVector> solutions(targets.size());
  std::size_t k = 0;
  for (auto _ : state) {
    solutions[k] = solve(k);
    k = (k + 1) % targets.size();
  }
  const RobotModel robot = kr210(true);
  int reached = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Eigen::Isometry3d X = forward_kinematics(robot, solutions[i]);
    reached += (X.translation() - targets[i].X_BF.translation()).norm() <= 1e-5 &&
               angle_between(X.linear(), targets[i].X_BF.linear()) <= 1e-8;
  }
  state.counters["reached"] = reached;
}

struct KdlTargets {
  std::vector<KDL::Frame> poses;
  std::vector<KDL::JntArray> seeds;

  KdlTargets() {
    for (const InverseTarget& target : inverse_targets()) {
      poses.push_back(kdl_frame(target.X_BF));
      seeds.push_back(kdl_joints(target.seed));
    }
  }
};

void inverse_lma(benchmark::State& state) {
  const KDL::Chain chain = kdl_chain(kr210(true));
  const Eigen::Matrix<double, 6, 1> weights = Eigen::Matrix<double, 6, 1>::Ones();
  KDL::ChainIkSolverPos_LMA solver(chain, weights, kKdlTolerance, kKdlIterations);
  const KdlTargets targets;
  KDL::JntArray q(6);
  solve_targets(state, [&](std::size_t k) {
    solver.CartToJnt(targets.seeds[k], targets.poses[k], q);
    return JointVector(q.data);
  });
}

void inverse_nr_jl(benchmark::State& state) {
  constexpr double kWider = 15 * kRadPerDeg;  // than the targets' limits, for the seeds' sake
  const RobotModel robot = kr210(true);
  const KDL::Chain chain = kdl_chain(robot);
  KDL::JntArray min(6), max(6);
  for (unsigned i = 0; i < 6; ++i) {
    min(i) = robot.joints[i].min - kWider;
    max(i) = robot.joints[i].max + kWider;
  }
  KDL::ChainFkSolverPos_recursive forward(chain);
  KDL::ChainIkSolverVel_pinv velocity(chain);
  KDL::ChainIkSolverPos_NR_JL solver(chain, min, max, forward, velocity, kKdlIterations, kKdlTolerance);
  const KdlTargets targets;
  KDL::JntArray q(6);
  solve_targets(state, [&](std::size_t k) {
    solver.CartToJnt(targets.seeds[k], targets.poses[k], q);
    return JointVector(q.data);
  });
}

void inverse_truepose(benchmark::State& state) {
  const ArmKernel arm{kr210(true)};
  const std::vector<InverseTarget>& targets = inverse_targets();
  const PoseInverseOptions options{.position_tolerance_mm = 1e-6, .rotation_tolerance_rad = 1e-9, .leaps = 8};
  solve_targets(state, [&](std::size_t k) {
    const auto solution = arm.inverse_near(targets[k].X_BF, targets[k].seed, options);
    return solution ? solution->q : targets[k].seed;
  });
}

void every_target(benchmark::internal::Benchmark* job) {
  job->Iterations(static_cast<benchmark::IterationCount>(inverse_targets().size()));
}
BENCHMARK(inverse_lma)->Name("inverse/kdl_lma")->Apply(every_target);
BENCHMARK(inverse_nr_jl)->Name("inverse/kdl_nr_jl")->Apply(every_target);
BENCHMARK(inverse_truepose)->Name("inverse/truepose")->Apply(every_target);

}  // namespace
}  // namespace truepose::bench
