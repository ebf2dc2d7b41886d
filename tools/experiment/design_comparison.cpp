#include <algorithm>
#include <cmath>

#include "core/identify/calibrate.hpp"
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

/// Errors of fits at the poses of the task, from one trial after the other.
struct Judged {
  double squares_mm2 = 0;  ///< sum over trials of the mean over the task
  double worst_mm = 0;     ///< sum over trials of the greatest over the task
  int trials = 0;

  void add(const CalibratedCell& fit, const CalibratedCell& truth, std::span<const JointVector> task) {
    double squares = 0, worst = 0;
    for (const JointVector& q : task) {
      const double square = (fit.predict(q, 0) - truth.predict(q, 0)).squaredNorm();
      squares += square / static_cast<double>(task.size());
      worst = std::max(worst, square);
    }
    squares_mm2 += squares;
    worst_mm += std::sqrt(worst);
    ++trials;
  }
};

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
    Judged judged;
    for (int index = 0; index < options.trials; ++index) {
      if (hooks.progress) hooks.progress(static_cast<double>(index) / options.trials, name + " poses");
      std::vector<JointVector> poses;
      for (const std::size_t k : chosen_of()) poses.push_back(candidates->poses[k]);
      const auto data = measure_campaign(arm, poses, {},
                                         {.tracker_noise_mm = options.tracker_noise_mm,
                                          .seed = set_up.noise_seed + static_cast<std::uint64_t>(index)})
                            .data;
      const auto fit = calibrate(nominal, data, {.prior = PriorUse::Off, .check_model = false});
      if (fit) judged.add(fit->cell, set_up.truth, *judged_at);
    }
    results.push_back({std::move(name), options.identify_poses, std::sqrt(judged.squares_mm2 / judged.trials),
                       judged.worst_mm / judged.trials});
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
