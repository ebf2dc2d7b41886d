#include <benchmark/benchmark.h>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>

#include "core/arm/arm_kernel.hpp"
#include "core/math/angles.hpp"
#include "tools/bench/jobs.hpp"
#include "tools/bench/kdl_arm.hpp"

namespace truepose::bench {
namespace {

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
