#include "core/experiment/design_comparison.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibration/calibrate.hpp"
#include "core/experiment/trial.hpp"
#include "core/planning/optimal_design.hpp"

namespace truepose {
namespace {

constexpr int kTaskPoses = 200;

std::vector<JointVector> chosen(const CalibratedCell& cell, const std::vector<JointVector>& candidates,
                                const std::vector<JointVector>& task, DesignCriterion criterion, int poses) {
  std::vector<JointVector> design;
  for (const std::size_t k : optimal_design(cell, candidates, task, {.criterion = criterion, .poses = poses}))
    design.push_back(candidates[k]);
  return design;
}

/// Adds the squared errors of one fit at the poses of the task.
void add_squares(const RobotModel& nominal, const TrueArmSetup& arm, const std::vector<JointVector>& design,
                 const std::vector<JointVector>& task, const CalibratedCell& truth,
                 const CampaignOptions& campaign, Eigen::ArrayXd& squares) {
  const auto fit = calibrate(nominal, measure_campaign(arm, design, {}, campaign).data,
                             {.prior = PriorUse::Off, .check_model = false});
  if (!fit) return;  // poses that identify in one trial identify in all: random ones fail as good as never
  for (Eigen::Index i = 0; i < squares.size(); ++i) {
    const JointVector& q = task[static_cast<std::size_t>(i)];
    squares[i] += (fit->cell.predict(q, 0) - truth.predict(q, 0)).squaredNorm();
  }
}

}  // namespace

std::vector<DesignResult> compare_designs(const RobotModel& nominal, const ExperimentOptions& options,
                                          const ExperimentHooks& hooks) {
  const Trial set_up = draw_trial(nominal, options, 0);
  const TrueArmSetup arm = true_arm(set_up, options);
  const CalibratedCell known{nominal, set_up.truth.base, set_up.truth.reflectors};
  Random random{set_up.noise_seed};
  const auto candidates =
      random_poses(nominal, std::max(options.design_candidates, options.identify_poses), random);
  const auto planned_for = random_poses(nominal, 1000, random);
  const auto task = random_poses(nominal, kTaskPoses, random);

  std::vector<DesignResult> results;
  const auto judge = [&](std::string name, auto poses_of) {
    Eigen::ArrayXd squares = Eigen::ArrayXd::Zero(kTaskPoses);
    for (int index = 0; index < options.trials; ++index) {
      if (hooks.progress) hooks.progress(static_cast<double>(index) / options.trials, name + " poses");
      const CampaignOptions campaign{.tracker_noise_mm = options.tracker_noise_mm,
                                     .seed = set_up.noise_seed + static_cast<std::uint64_t>(index)};
      add_squares(nominal, arm, poses_of(index), task, set_up.truth, campaign, squares);
    }
    squares /= options.trials;
    results.push_back(
        {std::move(name), options.identify_poses, std::sqrt(squares.mean()), std::sqrt(squares.maxCoeff())});
  };
  judge("random", [&](int index) { return draw_trial(nominal, options, index).identify; });
  for (const auto& [name, criterion] :
       {std::pair{"d-optimal", DesignCriterion::D}, {"i-optimal", DesignCriterion::I}}) {
    const auto design = chosen(known, candidates, planned_for, criterion, options.identify_poses);
    judge(name, [&](int) -> const std::vector<JointVector>& { return design; });
  }
  return results;
}

}  // namespace truepose
