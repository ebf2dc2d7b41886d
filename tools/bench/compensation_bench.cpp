#include <benchmark/benchmark.h>

#include "core/compensate/target_compensation.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "tools/bench/jobs.hpp"

namespace truepose::bench {
namespace {

/// Joint positions with axis 5 somewhere in between, to either side.
std::vector<JointVector> targets(double least_A5_deg, double largest_A5_deg) {
  Random random{5};
  std::vector<JointVector> joints;
  for (int k = 0; k < 1000; ++k) {
    const double A5 = random.uniform(least_A5_deg, largest_A5_deg);
    joints.push_back(kRadPerDeg * (JointVector(6) << random.uniform(-170, 170), random.uniform(-90, -40),
                                   random.uniform(60, 110), random.uniform(-170, 170),
                                   random.uniform(0, 1) < 0.5 ? A5 : -A5, random.uniform(-170, 170))
                                      .finished());
  }
  return joints;
}

template <typename Solve>
void solve_targets(benchmark::State& state, const std::vector<JointVector>& joints, Solve solve) {
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(solve(joints[k]));
    k = (k + 1) % joints.size();
  }
}

/// Newton to the whole pose, nothing prepared: what it costs to know no singularity.
void newton(benchmark::State& state, double least_A5_deg, double largest_A5_deg) {
  const RobotModel nominal = kr210(false), real = kr210(true);
  solve_targets(state, targets(least_A5_deg, largest_A5_deg),
                [&](const JointVector& q) { return inverse_near(real, forward_kinematics(nominal, q), q); });
}

void compensation(benchmark::State& state, double least_A5_deg, double largest_A5_deg) {
  const TargetCompensation prepared{kr210(false), kr210(true)};
  solve_targets(state, targets(least_A5_deg, largest_A5_deg), [&](const JointVector& q) {
    return prepared.at_joints(q, {120, -40, 300});
  });
}

BENCHMARK_CAPTURE(newton, regular, 25, 110)->Name("compensation/newton/regular");
BENCHMARK_CAPTURE(compensation, regular, 25, 110)->Name("compensation/truepose/regular");
BENCHMARK_CAPTURE(newton, damped, 3, 18)->Name("compensation/newton/damped");
BENCHMARK_CAPTURE(compensation, damped, 3, 18)->Name("compensation/truepose/damped");

}  // namespace
}  // namespace truepose::bench
