#include "core/plan/measurement_plan.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "core/math/random.hpp"
#include "core/plan/motion.hpp"
#include "core/plan/orientation_choice.hpp"

namespace truepose {
namespace {

constexpr int kTaskPoses = 400;
constexpr int kLeastTaskPoses = 50;
// What a stop on the way costs in addition to the longer way.
constexpr double kStopover_s = 3;
// Seeds of what must not depend on each other.
constexpr std::uint64_t kTaskStream = 0x7461736b, kRandomStream = 0x72616e64;

void shuffle(std::vector<std::size_t>& order, Random& random) {
  for (std::size_t i = order.size(); i-- > 1;) std::swap(order[i], order[random.next() % (i + 1)]);
}

std::vector<std::size_t> first_numbers(std::size_t count) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

PredictedError error_of_random_sets(const DesignProblem& problem, int poses, int sets, Random& random) {
  PredictedError mean;
  std::vector<std::size_t> order = first_numbers(problem.candidates());
  for (int set = 0; set < sets; ++set) {
    shuffle(order, random);
    const PredictedError error =
        predicted_error(problem, std::span{order}.first(static_cast<std::size_t>(poses)));
    mean.rms_mm += error.rms_mm / sets;
    mean.max_mm += error.max_mm / sets;
  }
  return mean;
}

double time_of_random_orders(const TourTimes& times, int sets, Random& random) {
  double mean_s = 0;
  std::vector<std::size_t> order = first_numbers(times.poses());
  for (int set = 0; set < sets; ++set) {
    shuffle(order, random);
    mean_s += times.total(order) / sets;
  }
  return mean_s;
}

/// Time of motions, in which those that are not clear cost about what a detour would.
TravelTime clear_travel_time(const Scene& scene) {
  return [robot = scene.robot, motion = std::make_shared<MotionChecker>(scene)](const JointVector& from,
                                                                                const JointVector& to) {
    const double direct_s = travel_time_s(robot, from, to);
    return motion->clear(from, to) ? direct_s : 2 * direct_s + kStopover_s;
  };
}

/// The pose that is nearest to the others.
const JointVector& central(const RobotModel& robot, const std::vector<JointVector>& poses) {
  const auto way_s = [&](const JointVector& q) {
    return std::transform_reduce(poses.begin(), poses.end(), 0.0, std::plus{},
                                 [&](const JointVector& other) { return travel_time_s(robot, q, other); });
  };
  std::vector<double> ways;
  for (const JointVector& q : poses) ways.push_back(way_s(q));
  return poses[static_cast<std::size_t>(std::ranges::min_element(ways) - ways.begin())];
}

std::vector<JointVector> picked(const Candidates& candidates, std::span<const std::size_t> which) {
  std::vector<JointVector> poses;
  for (const std::size_t k : which) poses.push_back(candidates.poses[k]);
  return poses;
}

/// Those of the chosen that together tell most come first, `count` of them.
void most_informative_first(std::vector<std::size_t>& chosen, const DesignProblem& problem, int count) {
  Design design{problem, DesignCriterion::D};
  std::vector<bool> allowed(problem.candidates());
  for (const std::size_t k : chosen) allowed[k] = true;
  for (int done = 0; done < count; ++done) {
    const auto next = best_addition(design, allowed);
    const auto rest = chosen.begin() + done;
    std::iter_swap(rest, std::find(rest, chosen.end(), *next));
    design.add(*next);
  }
}

/// Whether the reflector that is measured at a candidate is identified: shown at so many of the chosen poses
/// that its place on the flange does not follow from one measurement.
bool is_identified(const MeasurementPlan& plan, std::size_t candidate) {
  constexpr std::ptrdiff_t kFewest = 3;
  const std::vector<int>& seen = plan.candidates.seen;
  return seen.empty() || std::ranges::count_if(plan.chosen, [&](std::size_t k) {
                           return seen[k] == seen[candidate];
                         }) >= kFewest;
}

/// Random candidates that were not chosen, of reflectors that are identified.
std::vector<JointVector> draw_validation(const MeasurementPlan& plan, int count, Random& random) {
  std::vector<std::size_t> others;
  for (std::size_t k = 0; k < plan.candidates.poses.size(); ++k) {
    if (std::ranges::find(plan.chosen, k) == plan.chosen.end() && is_identified(plan, k)) others.push_back(k);
  }
  shuffle(others, random);
  others.resize(std::min(others.size(), static_cast<std::size_t>(count)));
  return picked(plan.candidates, others);
}

/// Orders the poses of the plan, those to identify first.
void put_in_order(MeasurementPlan& plan, const Scene& scene, const PlanOptions& options, Random& random) {
  const TravelTime time = clear_travel_time(scene);
  const std::vector<std::size_t> chosen = plan.chosen;
  const std::vector<JointVector> poses = picked(plan.candidates, chosen);
  if (options.reference_every > 0) plan.reference = central(scene.robot, poses);
  TourOptions tour_options{.start = options.start,
                           .first = static_cast<std::size_t>(options.first),
                           .reference = plan.reference.value_or(JointVector{}),
                           .reference_every = options.reference_every,
                           .seed = options.seed,
                           .progress = options.progress};
  const TravelTime direct_time = [&](const JointVector& from, const JointVector& to) {
    return travel_time_s(scene.robot, from, to);
  };
  const TourTimes times{time, direct_time, poses, tour_options};
  const Tour tour = shortest_tour(times, tour_options);
  plan.travel_s = tour.time_s;
  plan.random_travel_s = time_of_random_orders(times, options.random_sets, random);
  for (std::size_t i = 0; i < chosen.size(); ++i) plan.chosen[i] = chosen[tour.order[i]];
  plan.poses = picked(plan.candidates, plan.chosen);

  const std::vector<JointVector> drawn = draw_validation(plan, options.validate, random);
  tour_options.start = plan.poses.back();
  tour_options.first = 0;
  for (const std::size_t k : shortest_tour({time, direct_time, drawn, tour_options}, tour_options).order)
    plan.validate.push_back(drawn[k]);
}

}  // namespace

std::expected<std::vector<JointVector>, std::string> draw_task(const Scene& scene, const Box& task,
                                                               std::uint64_t seed) {
  Scene anywhere = scene;
  anywhere.workspace = task;
  const CandidateOptions options{
      .poses = kTaskPoses, .seed = seed ^ kTaskStream, .visibility = Visibility::Regardless};
  auto drawn = draw_candidates(anywhere, options, kLeastTaskPoses);
  if (!drawn) return std::unexpected("the task region: " + drawn.error());
  return std::move(drawn->poses);
}

namespace {

std::expected<Candidates, std::string> candidates_of(const Scene& scene, const PlanOptions& options) {
  const int least = options.poses + options.validate;
  return draw_candidates(scene, {.poses = std::max(options.candidates, least), .seed = options.seed}, least);
}

/// The index of a pose, which is added where it is none of the candidates.
std::size_t index_among(std::vector<JointVector>& candidates, const JointVector& q) {
  const auto found = std::ranges::find(candidates, q);
  const auto index = static_cast<std::size_t>(found - candidates.begin());
  if (found == candidates.end()) candidates.push_back(q);
  return index;
}

}  // namespace

std::expected<MeasurementPlan, std::string> plan_again(const CalibratedCell& cell, const Scene& scene,
                                                       const PlanOptions& options, EarlierPlan earlier) {
  auto candidates = candidates_of(scene, options);
  if (!candidates) return std::unexpected(std::move(candidates.error()));
  const auto task = draw_task(scene, options.task, options.seed);
  if (!task) return std::unexpected(task.error());
  MeasurementPlan plan;
  plan.candidates = *std::move(candidates);
  for (const JointVector& q : earlier.poses) plan.chosen.push_back(index_among(plan.candidates.poses, q));
  for (const JointVector& q : earlier.validate) index_among(plan.candidates.poses, q);
  plan.problem = std::make_shared<DesignProblem>(cell, plan.candidates.poses, *task, options.noise);
  plan.poses = std::move(earlier.poses);
  plan.validate = std::move(earlier.validate);
  plan.reference = std::move(earlier.reference);
  return plan;
}

std::expected<MeasurementPlan, std::string> plan_measurements(const CalibratedCell& cell, const Scene& scene,
                                                              const PlanOptions& options) {
  auto candidates = candidates_of(scene, options);
  if (!candidates) return std::unexpected(std::move(candidates.error()));
  const auto task = draw_task(scene, options.task, options.seed);
  if (!task) return std::unexpected(task.error());

  MeasurementPlan plan;
  plan.candidates = *std::move(candidates);
  plan.problem = std::make_shared<DesignProblem>(cell, plan.candidates.poses, *task, options.noise,
                                                 DesignPrior{}, plan.candidates.seen);
  const DesignProblem& problem = *plan.problem;
  if (options.progress) options.progress(0, "choice of the poses");
  DesignOptions design{.criterion = options.criterion, .poses = options.poses, .seed = options.seed};
  plan.chosen = options.by_orientation ? most_different_orientations(scene.robot, plan.candidates.poses,
                                                                     static_cast<std::size_t>(options.poses))
                                       : optimal_design(problem, design);
  most_informative_first(plan.chosen, problem, options.first);
  plan.predicted = predicted_error(problem, plan.chosen);
  Random random{options.seed ^ kRandomStream};
  plan.random = error_of_random_sets(problem, options.poses, options.random_sets, random);

  design.restarts = 0;
  std::vector<int> sizes = options.sizes;
  std::erase_if(sizes, [&](int size) { return static_cast<std::size_t>(size) > problem.candidates(); });
  plan.sizes = design_sizes(problem, design, sizes);
  plan.enough = enough_poses(plan.sizes, options.noise.repeatability_mm);
  put_in_order(plan, scene, options, random);
  return plan;
}

}  // namespace truepose
