#include <algorithm>
#include <cmath>
#include <optional>

#include "core/calibrate/calibrate.hpp"
#include "core/math/angles.hpp"
#include "core/plan/measurement_plan.hpp"
#include "tools/experiment/comparisons.hpp"
#include "tools/experiment/trial.hpp"

namespace truepose {
namespace {

/// A cell whose tracker stands 3.6 m from the arm, looking at it from the side that the reflector faces.
Scene visible_scene(const RobotModel& nominal) {
  Scene scene{.robot = nominal, .limit_margin_rad = 5 * kRadPerDeg};
  scene.sight = {.X_WB = pose_from_kuka({3420, 430, -1230}, {166, 0, 0}),
                 .p_FS_mm = {60, -50, 190},
                 .facing_F = {0.56, -0.43, 0.71},
                 .acceptance_rad = 30 * kRadPerDeg};
  return scene;
}

std::vector<std::size_t> random_choice(std::size_t candidates, int poses, Random& random) {
  std::vector<std::size_t> chosen;
  while (chosen.size() < static_cast<std::size_t>(poses)) {
    const std::size_t k = random.next() % candidates;
    if (std::ranges::find(chosen, k) == chosen.end()) chosen.push_back(k);
  }
  return chosen;
}

/// Errors of a fit at the poses of the task.
struct Judged {
  double square_mm2 = 0;  ///< mean
  double worst_mm = 0;
};

Judged judged(const CalibratedCell& fit, const CalibratedCell& truth, std::span<const JointVector> task) {
  double squares = 0, worst = 0;
  for (const JointVector& q : task) {
    const double square = (fit.predict(q, 0) - truth.predict(q, 0)).squaredNorm();
    squares += square / static_cast<double>(task.size());
    worst = std::max(worst, square);
  }
  return {squares, std::sqrt(worst)};
}

/// The mean over the trials that could be fitted.
DesignResult result_of(std::string name, int poses, const std::vector<std::optional<Judged>>& trials) {
  double squares = 0, worst = 0, fitted = 0;
  for (const auto& trial : trials) {
    if (!trial) continue;
    squares += trial->square_mm2;
    worst += trial->worst_mm;
    ++fitted;
  }
  return {std::move(name), poses, std::sqrt(squares / fitted), worst / fitted};
}

}  // namespace

std::vector<DesignResult> compare_designs(const RobotModel& nominal, const ExperimentOptions& options,
                                          const ExperimentHooks& hooks) {
  const Scene scene = visible_scene(nominal);
  const auto candidates = draw_candidates(
      scene, {.poses = std::max(options.design_candidates, options.identify_poses), .seed = options.seed},
      options.identify_poses);
  const auto planned_for = draw_task(scene, {}, options.seed),
             judged_at = draw_task(scene, {}, options.seed + 1);
  if (!candidates || !planned_for || !judged_at) return {};  // an arm that this tracker cannot see

  Trial set_up = draw_trial(nominal, options, 0);
  set_up.truth.base = BasePose::of(scene.sight.X_WB);
  set_up.truth.reflectors[0].p_FS_mm = scene.sight.p_FS_mm;
  const TrueArmSetup arm = true_arm(set_up, options);
  const CalibratedCell known{nominal, set_up.truth.base, set_up.truth.reflectors};
  const DesignProblem problem{
      known,
      candidates->poses,
      *planned_for,
      {.tracker = {.range_mm = options.tracker_noise_mm, .transverse_mm = options.tracker_noise_mm},
       .repeatability_mm = options.repeatability_mm}};

  std::vector<DesignResult> results;
  const auto judge = [&](std::string name, auto chosen_of) {
    const auto trials = static_cast<std::size_t>(options.trials);
    std::vector<std::vector<std::size_t>> chosen(trials);
    std::ranges::generate(chosen, chosen_of);
    std::vector<std::optional<Judged>> of_trials(trials);
    run_trials(options.trials, hooks, name + " poses", [&](int index) {
      const auto trial = static_cast<std::size_t>(index);
      std::vector<JointVector> poses;
      for (const std::size_t k : chosen[trial]) poses.push_back(candidates->poses[k]);
      const auto data = measure_campaign(arm, poses, {},
                                         {.tracker_noise_mm = options.tracker_noise_mm,
                                          .seed = set_up.noise_seed + static_cast<std::uint64_t>(index)})
                            .data;
      const auto fit = calibrate(nominal, data, {.prior = PriorUse::Off, .check_model = false});
      if (fit) of_trials[trial] = judged(fit->cell, set_up.truth, *judged_at);
    });
    results.push_back(result_of(std::move(name), options.identify_poses, of_trials));
  };
  Random random{options.seed};
  judge("random", [&] { return random_choice(candidates->poses.size(), options.identify_poses, random); });
  for (const auto& [name, criterion] :
       {std::pair{"d-optimal", DesignCriterion::D}, {"i-optimal", DesignCriterion::I}}) {
    const auto design = optimal_design(problem, {.criterion = criterion, .poses = options.identify_poses});
    judge(name, [&] { return design; });
  }
  return results;
}

}  // namespace truepose
