#include "core/judge/movement.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "core/identify/measured_time.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/judge/drift_causes.hpp"
#include "core/judge/joint_errors.hpp"
#include "core/judge/time_evidence.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewest = 3;          // poses before and after a step: fewer are single readings
constexpr double kLeastMovement_mm = 1e-3;  // less than that nobody measures
constexpr double kHalved = 0.5;             // of the standard deviation
constexpr double kByChance = 1e-3;          // of all that may have moved, at any moment
constexpr double kStatedCounts = 10;        // residuals: a stated noise is known to a quarter
constexpr double kGramTolerance = 1e-10;
constexpr std::size_t kMostMoments = 24;   // of which pairs are tried
constexpr double kRarer = 100;             // are two steps than one
constexpr std::ptrdiff_t kFewestAway = 5;  // poses between two steps: gross errors of few look like these

/// By how much better one of two explanations has to be, as logarithms of likelihood doubled, so that the
/// other is out of the question.
const double kOutOfQuestion = -2 * std::log(kByChance);

/// What may have moved: its columns among the parameters', and the points that it moves, as they were
/// measured.
struct Candidate {
  Mover what;
  int column = 0, columns = 0;
  std::vector<std::size_t> points;
};

/// What points say of columns beside the parameters.
struct Sums {
  Eigen::MatrixXd gram;   ///< of the columns
  Eigen::MatrixXd along;  ///< U' times them
  Eigen::VectorXd b;      ///< their product with the residuals

  Sums(const TimeEvidence& evidence, int columns)
      : gram{Eigen::MatrixXd::Zero(columns, columns)},
        along{Eigen::MatrixXd::Zero(evidence.U.cols(), columns)},
        b{Eigen::VectorXd::Zero(columns)} {}

  /// @param share  of the movement that the point has made
  void add(const TimeEvidence& evidence, const Candidate& candidate, std::size_t point, double share) {
    const Eigen::Index row = row_of(point);
    const Eigen::MatrixXd A = share * evidence.J.block(row, candidate.column, 3, candidate.columns);
    gram += truepose::gram(A);
    along += transposed_times(evidence.U.middleRows<3>(row), A);
    b += A.transpose() * evidence.r.segment<3>(row);
  }
  /// The columns of the one, then those of the other, for points that are not the same.
  Sums beside(const Sums& other) const {
    Sums both = *this;
    const Eigen::Index mine = b.size(), all = mine + other.b.size();
    both.gram = Eigen::MatrixXd::Zero(all, all);
    both.gram.topLeftCorner(mine, mine) = gram;
    both.gram.bottomRightCorner(all - mine, all - mine) = other.gram;
    both.along.conservativeResize(Eigen::NoChange, all);
    both.along.rightCols(all - mine) = other.along;
    both.b.conservativeResize(all);
    both.b.tail(all - mine) = other.b;
    return both;
  }
  Sums less(const Sums& other) const {
    Sums left = *this;
    left.gram -= other.gram;
    left.along -= other.along;
    left.b -= other.b;
    return left;
  }
  /// What of the columns explains the residuals best.
  Eigen::VectorXd step() const {
    const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd left = scale.asDiagonal() * (gram - truepose::gram(along)) * scale.asDiagonal();
    return scale.cwiseProduct(smallest_solution(left, scale.cwiseProduct(b), kGramTolerance));
  }
  /// Of the squares of the residuals, what that takes away.
  double gain() const { return step().dot(b); }
};

/// How much of a movement each point has made: a column for each movement, one after the other.
using Shares = Eigen::MatrixXd;

/// Of the residuals, what a movement leaves.
Eigen::VectorXd left_by(const TimeEvidence& evidence, const Candidate& candidate, const Shares& shares,
                        const Eigen::VectorXd& step) {
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(evidence.r.size());
  for (std::size_t k = 0; k < candidate.points.size(); ++k) {
    const Eigen::Index row = row_of(candidate.points[k]);
    for (Eigen::Index m = 0; m < shares.cols(); ++m) {
      moved.segment<3>(row) += shares(static_cast<Eigen::Index>(k), m) *
                               evidence.J.block(row, candidate.column, 3, candidate.columns) *
                               step.segment(m * candidate.columns, candidate.columns);
    }
  }
  return evidence.r - moved + times(evidence.U, transposed_times(evidence.U, moved));
}

/// Whether the stated noise explains residuals: along the beams, and across them.
bool explained(const TimeEvidence& evidence, const Eigen::VectorXd& left, Eigen::Index unknowns) {
  if (!evidence.noise_known) return false;
  double along2 = 0, degrees_along = 0;
  for (Eigen::Index row = 0; row < left.size(); row += 3) {
    const Eigen::Vector3d beam = evidence.beams.segment<3>(row);
    along2 += std::pow(beam.dot(left.segment<3>(row)), 2);
    degrees_along += 1 - (evidence.U.middleRows<3>(row).transpose() * beam).squaredNorm();
  }
  const double part_left = 1 - static_cast<double>(unknowns) / evidence.degrees;
  const auto fits = [=](double squares, double degrees) {
    return gamma_tail(squares / 2, part_left * degrees / 2) >= kSignificance;
  };
  return fits(along2, degrees_along) && fits(left.squaredNorm() - along2, evidence.degrees - degrees_along);
}

/// Chance of a share of squares beyond `share` for `unknowns` columns beside twice `shape` others, by the
/// beta distribution; a little too large for an odd number of them.
double beta_tail(double share, double shape, Eigen::Index unknowns) {
  double term = 1, sum = 1;
  for (Eigen::Index i = 1; i < (unknowns + 1) / 2; ++i) {
    term *= share * (shape + static_cast<double>(i) - 1) / static_cast<double>(i);
    sum += term;
  }
  return std::pow(1 - share, shape) * sum;
}

/// Of the squares of the residuals, what a movement takes away, and whether it leaves what the stated noise
/// explains.
struct Explained {
  double gain = 0;
  Eigen::Index unknowns = 0;
  bool as_stated = false;
};

bool halves(const Explained& by, const TimeEvidence& evidence) {
  const double all = evidence.r.squaredNorm(), left = std::max(0.0, all - by.gain);
  return left / static_cast<double>(evidence.degrees - by.unknowns) <
         kHalved * kHalved * all / evidence.degrees;
}

/// Chance at which columns explain so much where nothing moved: by a beta distribution, whatever the scale of
/// the noise, but that a stated one which explains what is left counts like so many residuals.
double chance(const Explained& by, const TimeEvidence& evidence) {
  if (!by.as_stated && !halves(by, evidence)) return 1;
  const double left = std::max(0.0, evidence.r.squaredNorm() - by.gain);
  const double stated = by.as_stated ? kStatedCounts : 0;
  const auto degrees_left = static_cast<double>(evidence.degrees - by.unknowns);
  return beta_tail(by.gain / (stated + left + by.gain), (stated + degrees_left) / 2, by.unknowns);
}

struct PossibleMovement {
  Movement movement;
  double chance = 1;  ///< at which as much is seen where nothing moved
  double criterion = std::numeric_limits<double>::infinity();  ///< akaike_criterion() of it
};

/// @param moments  unknown too: so many of the movement's
/// @param tried    so many others were as possible
PossibleMovement possible(Movement movement, const TimeEvidence& evidence, const Candidate& candidate,
                          const Shares& shares, const Sums& sums, int moments, double tried) {
  const Eigen::VectorXd step = sums.step();
  Explained by{.gain = step.dot(sums.b), .unknowns = step.size()};
  if (evidence.degrees <= by.unknowns) return {};
  by.as_stated = explained(evidence, left_by(evidence, candidate, shares, step), by.unknowns);
  movement.what = candidate.what;
  movement.halves = halves(by, evidence);
  double sum_mm = 0, count = 0;
  const Eigen::VectorXd first_step = step.head(candidate.columns);
  for (std::size_t k = 0; k < candidate.points.size(); ++k) {
    if (shares(static_cast<Eigen::Index>(k), 0) < 1) continue;
    const Eigen::Index row = row_of(candidate.points[k]);
    sum_mm += (evidence.moves.block(row, candidate.column, 3, candidate.columns) * first_step).norm();
    ++count;
  }
  movement.moved_mm = sum_mm / count;
  const double left2 = std::max(0.0, evidence.r.squaredNorm() - by.gain);
  const int unknowns = static_cast<int>(by.unknowns) + moments;
  return {movement, tried * chance(by, evidence), akaike_criterion(left2, evidence.degrees, unknowns)};
}

/// Which of the points of a candidate may come after a step: the first of a pose, with enough poses before it
/// and from it on. What the arm does at one stop, all reflectors of that pose show.
///
/// @param pose  of each point
/// @return places among the candidate's points
std::vector<std::size_t> moments_of(const Candidate& candidate, std::span<const int> pose) {
  const std::vector<std::size_t>& points = candidate.points;
  std::vector<std::size_t> begins;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (k == 0 || pose[points[k]] != pose[points[k - 1]]) begins.push_back(k);
  if (begins.size() < 2 * kFewest) return {};
  return {begins.begin() + kFewest, begins.end() - (kFewest - 1)};
}

Shares steps_at(const Candidate& candidate, std::initializer_list<std::size_t> moments) {
  Shares shares = Shares::Zero(std::ssize(candidate.points), std::ssize(moments));
  Eigen::Index m = 0;
  for (auto moment = moments.begin(); moment != moments.end(); ++moment, ++m) {
    const std::size_t end = std::next(moment) == moments.end() ? candidate.points.size() : *std::next(moment);
    shares.col(m)
        .segment(static_cast<Eigen::Index>(*moment), static_cast<Eigen::Index>(end - *moment))
        .setOnes();
  }
  return shares;
}

/// What all points from each place on say, and from the end on nothing.
std::vector<Sums> from_each_on(const TimeEvidence& evidence, const Candidate& candidate) {
  std::vector<Sums> from(candidate.points.size() + 1, Sums{evidence, candidate.columns});
  for (std::size_t k = candidate.points.size(); k-- > 0;) {
    from[k] = from[k + 1];
    from[k].add(evidence, candidate, candidate.points[k], 1);
  }
  return from;
}

/// The step that explains the points best. Any point may have been the first after it.
PossibleMovement best_step(const TimeEvidence& evidence, const Candidate& candidate,
                           std::span<const std::size_t> moments, const std::vector<Sums>& from,
                           double tried) {
  double most = -1;
  std::size_t first = 0;
  for (const std::size_t moment : moments) {
    if (const double gain = from[moment].gain(); gain > most) {
      most = gain;
      first = moment;
    }
  }
  return possible({.first = candidate.points[first]}, evidence, candidate, steps_at(candidate, {first}),
                  from[first], 1, tried * static_cast<double>(evidence.r.size() / 3));
}

/// The even movement that does.
PossibleMovement best_trend(const TimeEvidence& evidence, const Candidate& candidate, double tried) {
  const auto count = std::ssize(candidate.points);
  const Shares shares = Eigen::VectorXd::LinSpaced(count, 0, 1);
  Sums sums{evidence, candidate.columns};
  for (Eigen::Index k = 0; k < count; ++k)
    sums.add(evidence, candidate, candidate.points[static_cast<std::size_t>(k)], shares(k, 0));
  return possible({}, evidence, candidate, shares, sums, 0, tried);
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

/// Two steps, as of a tracker that was bumped and set back.
PossibleMovement best_two_steps(const TimeEvidence& evidence, const Candidate& candidate,
                                std::span<const std::size_t> moments, const std::vector<Sums>& from,
                                double tried) {
  const auto sums = [&](std::size_t first, std::size_t again) {
    return from[first].less(from[again]).beside(from[again]);
  };
  double most = 0;
  std::size_t first = 0, again = 0;
  const auto try_both = [&](std::size_t a, std::size_t b) {
    const auto first_at = std::ranges::lower_bound(moments, a),
               again_at = std::ranges::lower_bound(moments, b);
    if (again_at - first_at < kFewestAway) return;
    if (const double gain = sums(a, b).gain(); gain > most) {
      most = gain;
      first = a;
      again = b;
    }
  };
  const std::vector<std::size_t> some = thinned(moments);
  for (const std::size_t a : some)
    for (const std::size_t b : some) try_both(a, b);
  if (!(most > 0)) return {};
  for (const std::size_t a : around(first, moments, some.size())) try_both(a, again);
  for (const std::size_t b : around(again, moments, some.size())) try_both(first, b);
  for (const std::size_t a : around(first, moments, some.size())) try_both(a, again);
  const auto pairs = static_cast<double>(moments.size() * moments.size()) / 2;
  return possible({.first = candidate.points[first], .again = candidate.points[again]}, evidence, candidate,
                  steps_at(candidate, {first, again}), sums(first, again), 2, kRarer * tried * pairs);
}

/// Consecutive points, and those of them that nothing explains.
struct Stretch {
  double points = 0, far = 0, lengths_mm = 0;
  Eigen::Vector3d sum_mm{0, 0, 0};

  void add(const Eigen::Vector3d& error_mm, bool is_far) {
    points += 1;
    if (!is_far) return;
    far += 1;
    lengths_mm += error_mm.norm();
    sum_mm += error_mm;
  }
  /// Nearly all are far, and off in the same way.
  bool moved() const {
    constexpr double kNearlyAll = 2.0 / 3, kSameWay = 0.8;
    return far >= 2 && far >= kNearlyAll * points && sum_mm.norm() > kSameWay * lengths_mm;
  }
  bool stood() const {
    constexpr double kFew = 0.1;
    return far <= kFew * points;
  }
};

/// A moment that parts the far points of a station from the others.
std::optional<Movement> parting(std::span<const Eigen::Vector3d> errors_mm, const std::vector<bool>& is_far,
                                std::span<const std::size_t> points) {
  std::optional<Movement> found;
  double most = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    Stretch before, after;
    for (const std::size_t i : points) (i < points[k] ? before : after).add(errors_mm[i], is_far[i]);
    for (const auto& [moved, stood] : {std::pair{before, after}, std::pair{after, before}}) {
      const double right = moved.far + stood.points - stood.far;
      if (!moved.moved() || !stood.stood() || right <= most) continue;
      most = right;
      found = Movement{.first = points[k], .moved_mm = moved.lengths_mm / moved.far};
    }
  }
  return found;
}

/// Numbers of the points that a station sees, in their order.
std::vector<std::size_t> seen_from(std::span<const Measurement> points, int station) {
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].station == station) seen.push_back(i);
  return seen;
}

std::optional<Movement> parted(const CalibratedCell& cell, std::span<const Measurement> points,
                               const std::vector<bool>& is_far) {
  const Eigen::VectorXd f = residuals(cell, points);
  std::vector<Eigen::Vector3d> errors_mm;
  for (Eigen::Index row = 0; row < f.size(); row += 3) errors_mm.push_back(f.segment<3>(row));
  for (int station = 0; station < cell.station_count(); ++station) {
    auto found = parting(errors_mm, is_far, seen_from(points, station));
    if (!found) continue;
    found->what.number = station;
    return found;
  }
  return std::nullopt;
}

/// All that may have moved, the base of each station first.
std::vector<Candidate> possible_movers(const CalibratedCell& cell, std::span<const Measurement> points) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<std::size_t> all(points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<Candidate> found;
  for (int s = 0; s < layout.stations; ++s)
    found.push_back({{Moved::Base, s}, layout.base(s), ParameterLayout::kBase, seen_from(points, s)});
  for (int j = 0; j < layout.joints; ++j)
    found.push_back({{Moved::Joint, j}, zero_parameter(cell.robot, layout, j), 1, all});
  for (int k = 0; k < layout.reflectors; ++k) {
    std::vector<std::size_t> carried;
    for (const std::size_t i : all)
      if (points[i].smr == k) carried.push_back(i);
    found.push_back({{Moved::Reflector, k}, layout.reflector(k), ParameterLayout::kReflector, carried});
  }
  return found;
}

/// All movements that are not by chance.
std::vector<PossibleMovement> likely_movements(const CalibratedCell& cell, const TimeEvidence& evidence,
                                               std::span<const Measurement> points) {
  std::vector<PossibleMovement> likely;
  const auto consider = [&](const PossibleMovement& each) {
    if (each.chance < kByChance && each.movement.moved_mm >= kLeastMovement_mm) likely.push_back(each);
  };
  const std::vector<int> pose = pose_numbers(points);
  const std::vector<Candidate> all = possible_movers(cell, points);
  const auto others = static_cast<double>(all.size()) - cell.station_count();
  for (const Candidate& candidate : all) {
    const std::vector<std::size_t> moments = moments_of(candidate, pose);
    if (moments.empty()) continue;
    const bool is_base = candidate.what.kind == Moved::Base;
    const double tried = is_base ? 1 : others;  // mostly it is the tracker
    const std::vector<Sums> from = from_each_on(evidence, candidate);
    consider(best_step(evidence, candidate, moments, from, tried));
    if (candidate.what.kind != Moved::Joint) consider(best_trend(evidence, candidate, tried));
    if (is_base && likely.empty() && !explained(evidence, evidence.r, 0))
      consider(best_two_steps(evidence, candidate, moments, from, tried));
  }
  return likely;
}

/// Of all movements the one that explains the points best; mostly it is the tracker, unless that is out of
/// the question: of its movements the one that is least by chance.
///
/// @param likely  not empty
const PossibleMovement& likeliest(std::span<const PossibleMovement> likely) {
  const auto by_base = [](const PossibleMovement& each) {
    return each.movement.what.kind == Moved::Base ? each.chance : 1;
  };
  const auto best = std::ranges::min_element(likely, {}, &PossibleMovement::criterion);
  const auto base = std::ranges::min_element(likely, {}, by_base);
  return by_base(*base) < 1 && base->criterion < best->criterion + kOutOfQuestion ? *base : *best;
}

/// movement() of points in the order in which they were measured.
std::optional<Movement> movement_in_order(const CalibratedCell& cell, std::span<const Measurement> points,
                                          const std::optional<MeasurementNoise>& stated,
                                          const std::vector<bool>& is_far) {
  if (std::ranges::count(is_far, true) > 0) {
    if (auto found = parted(cell, points, is_far)) return found;
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
  const std::vector<PossibleMovement> likely = likely_movements(cell, evidence, others);
  if (likely.empty()) return std::nullopt;
  const PossibleMovement& best = likeliest(likely);
  const JointErrors joints = likeliest_joint_errors(cell, evidence, others);
  const double for_joints = best.criterion - joints.criterion;
  // Two moments fit whatever goes up and down with a joint that is swept.
  if (for_joints > (best.movement.again > 0 ? -kOutOfQuestion : kOutOfQuestion)) return std::nullopt;
  Movement found = best.movement;
  if (for_joints > -kOutOfQuestion) found.or_joint = joints.joint;
  for (const PossibleMovement& other : likely) {
    if (other.movement.what != found.what && other.criterion < best.criterion + kOutOfQuestion &&
        !std::ranges::count(found.or_else, other.movement.what))
      found.or_else.push_back(other.movement.what);
  }
  if (found.first > 0) found.first = number[found.first];
  if (found.again > 0) found.again = number[found.again];
  return found;
}

/// Times in seconds, where all points tell them.
std::optional<std::vector<double>> times_of(std::span<const Measurement> points) {
  std::vector<double> seconds;
  for (const Measurement& point : points) {
    const auto time = measured_time(point.time);
    if (!time) return std::nullopt;
    seconds.push_back(time->seconds);
  }
  return seconds;
}

/// Whether some pose was measured with a reflector more than once.
bool comes_back(std::span<const Measurement> points, std::span<const int> pose) {
  std::set<std::tuple<int, int, int>> seen;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!seen.insert({pose[i], points[i].smr, points[i].station}).second) return true;
  return false;
}

/// As they were measured: by their times where all tell them, else as they stand. All reflectors of a pose
/// were measured at one stop, though they may stand one reflector after the other.
std::vector<std::size_t> measured_order(std::span<const Measurement> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::vector<int> pose = pose_numbers(points);
  if (const auto seconds = times_of(points)) {
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return (*seconds)[i]; });
  } else if (!comes_back(points, pose)) {
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return pose[i]; });
  }
  return order;
}

/// How many points had been measured when it moved: of a base those of its station.
int measured_before(std::span<const Measurement> points, std::size_t moment, const Mover& what) {
  const auto before = points.first(moment);
  return static_cast<int>(what.kind == Moved::Base
                              ? std::ranges::count(before, what.number, &Measurement::station)
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
  if (found->first > 0) found->first = order[found->first];
  if (found->again > 0) found->again = order[found->again];
  return found;
}

}  // namespace truepose
