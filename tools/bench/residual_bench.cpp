#include <benchmark/benchmark.h>

#include <cmath>
#include <map>

#include "core/identify/calibrate.hpp"
#include "core/identify/regression_field.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tools/bench/jobs.hpp"

namespace truepose::bench {
namespace {

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
const RegressorPtr& fitted(RegressorKind kind) {
  static std::map<RegressorKind, RegressorPtr> all;
  RegressorPtr& one = all[kind];
  if (!one) one = fit_regressor(kind, residual_job().data.regression).value();
  return one;
}

/// One pose displaced by a field over 300 training poses; beside the time, what the field leaves of the
/// error.
void residual(benchmark::State& state, RegressorKind kind) {
  const ResidualJob& job = residual_job();
  CalibratedCell corrected = job.cell;
  corrected.robot.field = std::make_shared<RegressionField>(job.cell.robot, fitted(kind), job.data.p_F_mm);
  state.counters["before_mm"] = rms_left_mm(job.cell, job.campaign);
  state.counters["left_mm"] = rms_left_mm(corrected, job.campaign);

  std::size_t k = 0;
  for (auto _ : state) {
    const JointVector& q = job.campaign.data.points[kTrainingPoses + k].q;
    benchmark::DoNotOptimize(corrected.robot.field->displaced(q, Eigen::Isometry3d::Identity()));
    k = (k + 1) % kFreshPoses;
  }
}

BENCHMARK_CAPTURE(residual, gp, RegressorKind::GaussianProcess);
BENCHMARK_CAPTURE(residual, kriging, RegressorKind::Kriging);
BENCHMARK_CAPTURE(residual, idw, RegressorKind::InverseDistance);
BENCHMARK_CAPTURE(residual, mls, RegressorKind::MovingLeastSquares);
BENCHMARK_CAPTURE(residual, nn, RegressorKind::NeuralNetwork);

}  // namespace
}  // namespace truepose::bench
