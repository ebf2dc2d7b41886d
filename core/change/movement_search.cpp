#include "core/change/movement_search.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "core/arm/joint_deviation.hpp"
#include "core/change/stated_noise.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewest = 3;         // poses before and after a step: fewer are single readings
constexpr std::size_t kMostMoments = 24;   // of which pairs are tried
constexpr double kBends = 1e-3;            // of what all joints do under a load
constexpr std::ptrdiff_t kFewestAway = 5;  // poses between two steps: outliers of few look like these

/// Which of some points may come after a step: the first of a pose, with enough poses before it and from it
/// on. What the arm does at one stop, all reflectors of that pose show.
///
/// @param pose  of all points
/// @return places among the points
std::vector<std::size_t> moments_of(std::span<const std::size_t> points, std::span<const int> pose) {
  std::vector<std::size_t> begins;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (k == 0 || pose[points[k]] != pose[points[k - 1]]) begins.push_back(k);
  if (begins.size() < 2 * kFewest) return {};
  return {begins.begin() + kFewest, begins.end() - (kFewest - 1)};
}

/// Some of the moments, evenly spread.
std::vector<std::size_t> thinned(std::span<const std::size_t> moments) {
  const std::size_t count = std::min(moments.size(), kMostMoments);
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(moments[i * moments.size() / count]);
  return some;
}

/// The moments about one of those that were thinned to so many, as far as its neighbours.
std::span<const std::size_t> around(std::size_t moment, std::span<const std::size_t> moments,
                                    std::size_t thinned_to) {
  const auto at = static_cast<std::size_t>(std::ranges::lower_bound(moments, moment) - moments.begin());
  const std::size_t apart = moments.size() / thinned_to + 1, first = at - std::min(at, apart);
  return moments.subspan(first, std::min(moments.size(), at + apart + 1) - first);
}

/// Derivatives of the points to what a change leaves open.
///
/// @param J  to all parameters
Eigen::MatrixXd columns_of(const PossibleChange& change, const Eigen::MatrixXd& J, const CalibratedCell& cell,
                           std::span<const Measurement> points) {
  if (change.what.kind != ChangeKind::Load) return times(J, directions_of({&change, 1}, cell));
  const ParameterLayout layout = ParameterLayout::of(cell);
  RobotModel bending = cell.robot;
  bending.deviation.clear();
  for (int i = 0; i < layout.joints; ++i)
    if (bending.joints[static_cast<std::size_t>(i)].type == JointType::Revolute)
      bending.deviation.push_back({.joint = i, .basis = DeviationBasis::Weight, .order = layout.joints + 1});
  std::vector<double> torques(bending.deviation.size());
  Eigen::MatrixXd columns(J.rows(), std::ssize(torques));
  for (std::size_t k = 0; k < points.size(); ++k) {
    deviation_basis(bending, points[k].q, points[k].direction, torques);
    for (std::size_t t = 0; t < torques.size(); ++t)
      columns.block<3, 1>(row_of(k), static_cast<Eigen::Index>(t)) =
          torques[t] *
          J.block<3, 1>(row_of(k), zero_parameter(cell.robot, layout, bending.deviation[t].joint));
  }
  // What stands upright does not bend.
  std::vector<int> bent;
  for (int t = 0; t < columns.cols(); ++t)
    if (columns.col(t).norm() > kBends * columns.norm()) bent.push_back(t);
  return columns(Eigen::all, bent);
}

}  // namespace

/// What is fitted, of a movement of unknown size.
struct MovementSearch::Trial {
  TimeProfile profile;
  Shares shares;
  ReducedEquations equations;
  double moments = 1;  ///< so many were as possible
};

MovementSearch::MovementSearch(const TimeEvidence& evidence, const CalibratedCell& cell,
                               const PossibleChange& change, std::span<const Measurement> points,
                               std::span<const int> pose, double others)
    : evidence_{evidence},
      what_{change.what},
      J_{columns_of(change, evidence.J, cell, points)},
      moves_{columns_of(change, evidence.moves, cell, points)},
      columns_{J_.cols()},
      others_{others} {
  if (columns_ == 0) return;
  std::set<int> shown;  // all points of a pose take part that one of them shows
  for (std::size_t i = 0; i < points.size(); ++i)
    if (shows(points[i], what_)) shown.insert(pose[i]);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool of_station = what_.kind != ChangeKind::Base || shows(points[i], what_);
    if (of_station && shown.contains(pose[i])) points_.push_back(i);
  }
  moments_ = moments_of(points_, pose);
  if (moments_.empty()) return;
  from_.assign(points_.size() + 1, ReducedEquations{evidence_, columns_});
  for (std::size_t k = points_.size(); k-- > 0;) {
    from_[k] = from_[k + 1];
    from_[k].add(evidence_, points_[k], columns_at(J_, k));
  }
}

Movement MovementSearch::best_step() const {
  double most = -1;
  std::size_t first = 0;
  for (const std::size_t moment : moments_) {
    if (const double gain = from_[moment].evidence(evidence_).gain(); gain > most) {
      most = gain;
      first = moment;
    }
  }
  Movement step;
  step.first = points_[first];
  return fitted(step, {TimeProfile::Step, steps_at({first}), from_[first],
                       static_cast<double>(evidence_.r.size() / 3)});
}

Movement MovementSearch::always() const {
  return fitted({}, {TimeProfile::BetweenChecks, Eigen::VectorXd::Ones(std::ssize(points_)), from_.front()});
}

Movement MovementSearch::trend() const {
  const auto count = std::ssize(points_);
  const Shares shares = Eigen::VectorXd::LinSpaced(count, 0, 1);
  ReducedEquations equations{evidence_, columns_};
  for (std::size_t k = 0; k < points_.size(); ++k)
    equations.add(evidence_, points_[k], shares(static_cast<Eigen::Index>(k), 0) * columns_at(J_, k));
  return fitted({}, {TimeProfile::Linear, shares, equations});
}

Movement MovementSearch::best_two_steps() const {
  const TwoMoments at = best_moments();
  if (!(at.gain > 0)) return {};
  Movement steps;
  steps.first = points_[at.first];
  steps.again = points_[at.again];
  return fitted(steps,
                {TimeProfile::TwoSteps, steps_at({at.first, at.again}), between_and_after(at.first, at.again),
                 static_cast<double>(moments_.size() * moments_.size()) / 2});
}

/// Of some of the moments the best two, then of those about these.
MovementSearch::TwoMoments MovementSearch::best_moments() const {
  TwoMoments best;
  const auto place = [&](std::size_t moment) { return std::ranges::lower_bound(moments_, moment); };
  const auto try_both = [&](std::size_t first, std::size_t again) {
    if (place(again) - place(first) < kFewestAway) return;
    const double gain = between_and_after(first, again).evidence(evidence_).gain();
    if (gain > best.gain) best = {first, again, gain};
  };
  const std::vector<std::size_t> some = thinned(moments_);
  for (const std::size_t first : some)
    for (const std::size_t again : some) try_both(first, again);
  if (!(best.gain > 0)) return best;
  for (const std::size_t first : around(best.first, moments_, some.size())) try_both(first, best.again);
  for (const std::size_t again : around(best.again, moments_, some.size())) try_both(best.first, again);
  for (const std::size_t first : around(best.first, moments_, some.size())) try_both(first, best.again);
  return best;
}

ReducedEquations MovementSearch::between_and_after(std::size_t first, std::size_t again) const {
  return from_[first].less(from_[again]).joined_with(from_[again]);
}

MovementSearch::Shares MovementSearch::steps_at(std::initializer_list<std::size_t> moments) const {
  Shares shares = Shares::Zero(std::ssize(points_), std::ssize(moments));
  Eigen::Index m = 0;
  for (auto moment = moments.begin(); moment != moments.end(); ++moment, ++m) {
    const std::size_t end = std::next(moment) == moments.end() ? points_.size() : *std::next(moment);
    shares.col(m)
        .segment(static_cast<Eigen::Index>(*moment), static_cast<Eigen::Index>(end - *moment))
        .setOnes();
  }
  return shares;
}

/// Of the residuals, what a movement leaves.
Eigen::VectorXd MovementSearch::left_by(const Shares& shares, const Eigen::VectorXd& step) const {
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(evidence_.r.size());
  for (std::size_t k = 0; k < points_.size(); ++k)
    for (Eigen::Index m = 0; m < shares.cols(); ++m)
      moved.segment<3>(row_of(points_[k])) +=
          shares(static_cast<Eigen::Index>(k), m) * columns_at(J_, k) * step.segment(m * columns_, columns_);
  return evidence_.r - moved + times(evidence_.U, transposed_times(evidence_.U, moved));
}

/// What the first movement did to the points that have made all of it, on average.
double MovementSearch::moved_mm(const Shares& shares, const Eigen::VectorXd& step) const {
  double sum_mm = 0, count = 0;
  const Eigen::VectorXd first_step = step.head(columns_);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (shares(static_cast<Eigen::Index>(k), 0) < 1 || columns_at(moves_, k).isZero(0)) continue;
    sum_mm += (columns_at(moves_, k) * first_step).norm();
    ++count;
  }
  return sum_mm / count;
}

Movement MovementSearch::fitted(Movement movement, const Trial& trial) const {
  const ChangeEvidence evidence = trial.equations.evidence(evidence_);
  const Eigen::VectorXd step = evidence.step();
  if (evidence_.degrees <= step.size()) return {};
  movement.what = what_;
  movement.profile = trial.profile;
  movement.evidence = evidence.best() - std::log(trial.moments);
  movement.moved = step;
  movement.sigma = evidence.sigma();
  movement.halves = halves(evidence.gain(), step.size(), evidence_);
  movement.moved_mm = moved_mm(trial.shares, step);
  const StatedNoise left = stated_noise(evidence_, left_by(trial.shares, step), step.size());
  movement.chance = others_ * trial.moments * chance_of(evidence, left, movement.halves);
  return movement;
}

}  // namespace truepose
