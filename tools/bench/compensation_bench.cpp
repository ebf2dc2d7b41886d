#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "core/arm/forward.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/field/gaussian_process.hpp"
#include "core/fit/regression_field.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "proto/krl/program.hpp"
#include "proto/krl/rewrite.hpp"
#include "tools/bench/jobs.hpp"
#include "tools/truepose/krl/program_compensation.hpp"

namespace truepose::bench {
namespace {

// ---- Targets ----

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

// ---- Residual fields ----

constexpr int kTrainingPoses = 300, kFreshPoses = 512;

/// What a geometric calibration leaves of an arm whose joints give way.
struct ResidualJob {
  SimulatedCampaign campaign;  // its fresh poses are those to validate
  CalibratedCell cell;
  FieldData data;
};

ResidualJob make_residual_job() {
  Random random{4};
  const RobotModel nominal = kr210(false);
  const TrueArmSetup arm{.robot = kr210(true),
                         .non_geometric = heavy_arm_errors({}),
                         .p_FS_mm = {80, 40, 120},
                         .repeatability_mm = kRepeatability_mm};
  const std::vector<JointVector> training = random_poses(nominal, kTrainingPoses, random);
  ResidualJob job{.campaign = measure_campaign(arm, training, random_poses(nominal, kFreshPoses, random), {}),
                  .cell = {},
                  .data = {}};
  job.cell = calibrate(nominal, job.campaign.data).value().cell;
  job.data = field_data(job.cell, points_of(job.campaign.data, PoseSet::Identify));
  return job;
}

const ResidualJob& residual_job() {
  static const ResidualJob job = make_residual_job();
  return job;
}

double rms_left_mm(const CalibratedCell& cell, const SimulatedCampaign& campaign) {
  double sum = 0;
  for (std::size_t i = kTrainingPoses; i < campaign.p_true_mm.size(); ++i) {
    const Measurement& m = campaign.data.points[i];
    sum += (cell.predict(m.q, m.smr, m.direction) - campaign.p_true_mm[i]).squaredNorm();
  }
  return std::sqrt(sum / kFreshPoses);
}

/// Fitted once, however often its benchmark is repeated.
const RegressorPtr& fitted() {
  static const RegressorPtr one = fit_regressor(kGaussianProcess, residual_job().data.regression).value();
  return one;
}

/// One pose displaced by a field over 300 training poses: the time, and the residual error.
void residual(benchmark::State& state) {
  const ResidualJob& job = residual_job();
  CalibratedCell corrected = job.cell;
  corrected.robot.field = std::make_shared<RegressionField>(job.cell.robot, fitted(), job.data.p_F_mm);
  state.counters["before_mm"] = rms_left_mm(job.cell, job.campaign);
  state.counters["left_mm"] = rms_left_mm(corrected, job.campaign);

  std::size_t k = 0;
  for (auto _ : state) {
    const JointVector& q = job.campaign.data.points[kTrainingPoses + k].q;
    benchmark::DoNotOptimize(corrected.robot.field->displaced(q, Eigen::Isometry3d::Identity()));
    k = (k + 1) % kFreshPoses;
  }
}

BENCHMARK(residual)->Name("residual/gp");

// ---- KRL programs ----

constexpr int kPoints = 100'000;

struct ProgramFiles {
  std::string src = "DEF BIG()\n";
  std::string dat = "DEFDAT BIG\n";
};

std::string declaration(int k, const Eigen::Isometry3d& X_BF, const StatusTurn& at) {
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X_BF.linear());
  const Eigen::Vector3d p_mm = X_BF.translation();
  char line[240];
  std::snprintf(line, sizeof line,
                "DECL E6POS XP%d={X %.3f,Y %.3f,Z %.3f,A %.4f,B %.4f,C %.4f,S %d,T %d,"
                "E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}\n",
                k, p_mm.x(), p_mm.y(), p_mm.z(), abc_deg.x(), abc_deg.y(), abc_deg.z(), at.status, at.turn);
  return line;
}

/// A program as a controller saves it: its positions in the data list, a motion to each.
ProgramFiles make_program() {
  const RobotModel nominal = kr210(false);
  const auto inverse = StatusTurnInverse::of(nominal).value();
  ProgramFiles files;
  Random random{6};
  const std::vector<JointVector> joints = random_poses(nominal, kPoints, random);
  for (int k = 0; k < kPoints; ++k) {
    const JointVector& q = joints[static_cast<std::size_t>(k)];
    files.dat += declaration(k, forward_kinematics(nominal, q), inverse.of_joints(q));
    files.src += "PTP XP" + std::to_string(k) + "\n";
  }
  files.src += "END\n";
  files.dat += "ENDDAT\n";
  return files;
}

// Neither tool nor base.
const krl::StartFrames kAtFlange{Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()};

/// Texts in, texts out.
void program(benchmark::State& state) {
  static const ProgramFiles files = make_program();
  const RobotModel nominal = kr210(false), real = kr210(true);
  const auto inverse = StatusTurnInverse::of(nominal).value();
  double corrected = 0;
  for (auto _ : state) {
    const auto read = krl::read_program({files.src, files.dat, {}}, kAtFlange).value();
    const auto done = tools::compensate_program(read, nominal, inverse, real).value();
    benchmark::DoNotOptimize(krl::rewritten(files.src, done.src_edits));
    benchmark::DoNotOptimize(krl::rewritten(files.dat, done.dat_edits));
    corrected = static_cast<double>(done.changes.size());
  }
  state.counters["corrected"] = corrected;
}

BENCHMARK(program)->Name("program/truepose")->Iterations(1);

}  // namespace
}  // namespace truepose::bench
