#include "core/change/movement.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/change/far_stretch.hpp"
#include "core/change/joint_errors.hpp"
#include "core/change/movement_search.hpp"
#include "core/change/stated_noise.hpp"
#include "core/change/time_evidence.hpp"
#include "core/data/error_bounds.hpp"
#include "core/fit/measured_order.hpp"
#include "core/frames/positioner.hpp"

namespace truepose {
namespace {

/// By how much the evidence of one of two explanations has to be greater for the other to be out of the
/// question.
const double kOutOfQuestion = std::log(1000.0);

/// All that may move while it is measured.
std::vector<PossibleChange> movers_of(const CalibratedCell& cell) {
  std::vector<PossibleChange> all = bases_of(cell);
  std::ranges::copy(joint_zeros_of(cell), std::back_inserter(all));
  std::ranges::copy(reflectors_of(cell), std::back_inserter(all));
  all.push_back(growth_of(cell));
  if (cell.robot.joint_count() > 1) all.push_back(all_zeros_of(cell));
  all.push_back({{ChangeKind::Load}, {}});
  return all;
}

/// All movements that are not by chance, those of bases first.
std::vector<Movement> likely_movements(const CalibratedCell& cell, const TimeEvidence& evidence,
                                       std::span<const Measurement> points) {
  std::vector<Movement> likely;
  const auto consider = [&](const Movement& each) {
    const bool by_chance = each.chance >= row_of(each).most_false_alarms;
    if (!by_chance && each.moved_mm >= kLeastError_mm) likely.push_back(each);
  };
  const std::vector<int> pose = pose_numbers(points);
  const std::vector<PossibleChange> all = movers_of(cell);
  const auto but_bases = static_cast<double>(all.size()) - cell.station_count();
  for (const PossibleChange& change : all) {
    const ChangeKind kind = change.what.kind;
    const bool is_base = kind == ChangeKind::Base;
    const double others = is_base ? 1 : but_bases;  // mostly it is the tracker
    const MovementSearch search(evidence, cell, change, points, pose, others);
    if (!search.has_moments()) continue;
    const Movement step = search.best_step();
    // An arm that bends under what it always carries shows as much where its model does not bend.
    const bool bends = kind == ChangeKind::Load && step.evidence < search.always().evidence + kOutOfQuestion;
    if (!bends) consider(step);
    if (is_base || kind == ChangeKind::Reflector) consider(search.trend());
    if (is_base && likely.empty() && stated_noise(evidence, evidence.r, 0) != StatedNoise::Explains)
      consider(search.best_two_steps());
  }
  return likely;
}

/// Of all movements the most probable one, by its evidence and the prior of its hypothesis.
///
/// @param likely  not empty
const Movement& likeliest(std::span<const Movement> likely) {
  return *std::ranges::max_element(
      likely, {}, [](const Movement& each) { return each.evidence + std::log(row_of(each).prior); });
}

/// The likeliest movement, and what else explains the points; none where a joint's errors do so better beyond
/// question.
///
/// @param by_warmth  evidence of warm_up()
/// @param likely  not empty
std::optional<Movement> choice(std::span<const Movement> likely, const ChangeFound& joints,
                               double by_warmth) {
  const Movement& best = likeliest(likely);
  const double for_joints = joints.evidence - best.evidence;
  // Two moments fit whatever goes up and down with a joint that is swept.
  if (for_joints > (best.again > 0 ? -kOutOfQuestion : kOutOfQuestion)) return std::nullopt;
  Movement found = best;
  if (for_joints > -kOutOfQuestion) found.or_joint = joints.what.index;
  found.or_warmth = by_warmth > best.evidence - kOutOfQuestion;
  for (const Movement& other : likely) {
    if (other.what != found.what && other.evidence > best.evidence - kOutOfQuestion &&
        !std::ranges::count(found.or_else, other.what, &ChangeHypothesis::what))
      found.or_else.push_back(other);
  }
  return found;
}

/// Numbers a movement's points as `number` does.
std::optional<Movement> renumbered(std::optional<Movement> found, std::span<const std::size_t> number) {
  if (found && found->first > 0) found->first = number[found->first];
  if (found && found->again > 0) found->again = number[found->again];
  return found;
}

/// movement() of points in the order in which they were measured.
std::optional<Movement> movement_in_order(const CalibratedCell& cell, std::span<const Measurement> points,
                                          const std::optional<MeasurementNoise>& stated,
                                          const std::vector<bool>& is_far) {
  if (std::ranges::count(is_far, true) > 0) {
    if (auto found = far_stretch(cell, points, is_far)) return found;
  }
  std::vector<Measurement> others;
  std::vector<std::size_t> number;  // of each of the others among all
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_far[i]) continue;
    others.push_back(points[i]);
    number.push_back(i);
  }
  if (others.empty()) return std::nullopt;
  const TimeEvidence evidence = time_evidence(cell, others, stated);
  if (evidence.degrees <= 0) return std::nullopt;
  const std::vector<Movement> likely = likely_movements(cell, evidence, others);
  if (likely.empty()) return std::nullopt;
  const double by_warmth = is_positioner(cell.robot) ? -std::numeric_limits<double>::infinity()
                                                     : warm_up(cell, evidence, others).evidence;
  return renumbered(choice(likely, likeliest_joint_errors(cell, evidence, others), by_warmth), number);
}

/// How many points had been measured when it moved: of a base those of its station.
int measured_before(std::span<const Measurement> points, std::size_t moment, const Change& what) {
  const auto before = points.first(moment);
  return static_cast<int>(what.kind == ChangeKind::Base
                              ? std::ranges::count(before, what.index, &Measurement::station)
                              : std::ssize(before));
}

}  // namespace

std::optional<Movement> movement(const CalibratedCell& cell, std::span<const Measurement> points,
                                 const std::optional<MeasurementNoise>& stated,
                                 std::span<const std::size_t> far) {
  const std::vector<std::size_t> order = measured_order(points);
  std::vector<bool> far_at(points.size());
  for (const std::size_t i : far) far_at[i] = true;
  std::vector<Measurement> measured;
  std::vector<bool> is_far;
  for (const std::size_t i : order) {
    measured.push_back(points[i]);
    is_far.push_back(far_at[i]);
  }
  auto found = movement_in_order(cell, measured, stated, is_far);
  if (!found) return std::nullopt;
  found->before = measured_before(measured, found->first, found->what);
  found->before_again = measured_before(measured, found->again, found->what);
  return renumbered(found, order);
}

}  // namespace truepose
