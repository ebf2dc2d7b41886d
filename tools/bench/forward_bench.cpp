#include <benchmark/benchmark.h>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "core/arm/arm_kernel.hpp"
#include "tools/bench/jobs.hpp"
#include "tools/bench/kdl_arm.hpp"

namespace truepose::bench {
namespace {

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

}  // namespace
}  // namespace truepose::bench
