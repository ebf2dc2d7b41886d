#include "tools/experiment/trial.hpp"

#include <cmath>
#include <mutex>
#include <numbers>

#include "core/compensate/target_compensation.hpp"
#include "core/compensate/tracker_loop.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/math/angles.hpp"
#include "core/math/parallel.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose {

std::optional<JointVector> joints_for_reflector(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm,
                                                const JointVector& q_seed,
                                                const ApproachDirections& directions) {
  const TargetCompensation arm{cell.robot, cell.robot, {.approach = directions}};
  const auto found =
      arm.at_position(inverse_of(cell.base.isometry()) * p_WS_mm, q_seed, cell.reflectors.front().p_FS_mm);
  if (!found) return std::nullopt;
  return found->q;
}

Eigen::Vector3d approach_with_tracker(TrueArm& arm, const CalibratedCell& cell,
                                      const Eigen::Vector3d& p_WS_mm, const JointVector& q,
                                      const TrackerReadings& readings, Random& random) {
  TrackerLoop loop{cell, p_WS_mm, q, {.rounds = readings.rounds, .tolerance_mm = 0}};
  while (!loop.end()) {
    Eigen::Vector3d reading = arm.p_WS_mm(loop.q());
    for (double& axis : reading) axis += readings.noise_mm * random.normal();
    loop.add(reading);
    arm.move_to(loop.q());
  }
  return arm.p_WS_mm(loop.q());
}

namespace {

Eigen::Vector3d within(double limit, Random& random) {
  Eigen::Vector3d v;
  for (double& axis : v) axis = random.uniform(-limit, limit);
  return v;
}

/// A point in the xy plane, at a uniform distance in a uniform direction.
Eigen::Vector3d around(double nearest_mm, double farthest_mm, Random& random) {
  const double distance_mm = random.uniform(nearest_mm, farthest_mm);
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  return {distance_mm * std::cos(angle), distance_mm * std::sin(angle), 0};
}

}  // namespace

Trial draw_trial(const RobotModel& nominal, const ExperimentOptions& options, int index) {
  // Seeds of neighbouring trials differ in one bit; the generator's first number scatters them.
  Random random{Random{options.seed}.next() + static_cast<std::uint64_t>(index)};

  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.translation() = around(3000, 6000, random);
  X_WB.translation().z() = random.uniform(-1000, 0);
  X_WB.linear() = rotation_by(within(std::numbers::pi / 2, random));
  Eigen::Vector3d p_FS_mm = around(100, 250, random);
  p_FS_mm.z() = random.uniform(50, 150);

  Trial trial;
  trial.truth = {with_published_errors(nominal), BasePose::of(X_WB), {{"1", p_FS_mm}}};
  Eigen::VectorXd off = Eigen::VectorXd::Zero(ParameterLayout::of(trial.truth).size());
  off.segment<3>(0) = within(options.guess.base_mm, random);
  off.segment<3>(3) = within(options.guess.base_rad, random);
  off.segment<3>(6) = within(options.guess.smr_mm, random);
  trial.guess = moved({nominal, trial.truth.base, trial.truth.reflectors}, off);
  trial.identify = random_poses(nominal, options.identify_poses, random);
  trial.validate = random_poses(nominal, options.validate_poses, random);
  trial.noise_seed = random.next();
  return trial;
}

TrueArmSetup true_arm(const Trial& trial, const ExperimentOptions& options) {
  return {.robot = trial.truth.robot,
          .X_WB = trial.truth.base.isometry(),
          .p_FS_mm = trial.truth.reflectors.front().p_FS_mm,
          .repeatability_mm = options.repeatability_mm};
}

SimulatedCampaign measure_trial(const Trial& trial, const ExperimentOptions& options, TrialData data) {
  TrueArmSetup arm = true_arm(trial, options);
  CampaignOptions campaign{.tracker_noise_mm = options.tracker_noise_mm, .seed = trial.noise_seed};
  if (data == TrialData::NoiseFree) arm.repeatability_mm = campaign.tracker_noise_mm = 0;
  if (data == TrialData::GrossErrors) campaign.gross = options.gross;
  return measure_campaign(arm, trial.identify, trial.validate, campaign);
}

void run_trials(int count, const ExperimentHooks& hooks, std::string_view doing,
                const std::function<void(int)>& run) {
  std::mutex mutex;
  int begun = 0;
  parallel_for(count, hooks.jobs, [&](int index) {
    if (hooks.progress) {
      const std::lock_guard lock(mutex);
      hooks.progress(static_cast<double>(begun++) / count, doing);
    }
    run(index);
  });
}

double reading_sigma_mm(const ExperimentOptions& options) {
  return std::hypot(options.tracker_noise_mm, options.repeatability_mm);
}

}  // namespace truepose
