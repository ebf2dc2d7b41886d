#include "core/judge/movement.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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
constexpr double kByChance = 1e-3;          // of all moments together, and of an even movement
constexpr double kStatedCounts = 10;        // residuals: a stated noise is known to a quarter
constexpr int kUnknowns = ParameterLayout::kBase;
constexpr double kGramTolerance = 1e-10;

/// By how much better one of two explanations has to be, as logarithms of likelihood doubled, so that the
/// other is out of the question.
const double kOutOfQuestion = -2 * std::log(kByChance);

using BaseStep = Eigen::Matrix<double, kUnknowns, 1>;

/// Six columns beside the parameters, point by point.
class BaseColumns {
 public:
  explicit BaseColumns(const TimeEvidence& evidence)
      : evidence_{evidence},
        columns_{Eigen::MatrixXd::Zero(evidence.r.size(), kUnknowns)},
        along_{Eigen::MatrixXd::Zero(evidence.U.cols(), kUnknowns)} {}

  /// @param share  of the movement that the point has made
  void add(std::size_t point, double share) {
    const Eigen::Index row = row_of(point);
    const Eigen::MatrixXd A = share * evidence_.columns.middleRows<3>(row);
    columns_.middleRows<3>(row) = A;
    gram_ += truepose::gram(A);
    along_ += transposed_times(evidence_.U.middleRows<3>(row), A);
    b_ += A.transpose() * evidence_.r.segment<3>(row);
  }

  /// What of the base explains the residuals best.
  BaseStep step() const {
    const BaseStep scale = gram_.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd left = scale.asDiagonal() * (gram_ - truepose::gram(along_)) * scale.asDiagonal();
    return scale.cwiseProduct(BaseStep{smallest_solution(left, scale.cwiseProduct(b_), kGramTolerance)});
  }
  /// Of the squares of the residuals, what a step takes away.
  double gain(const BaseStep& step) const { return step.dot(b_); }
  /// Of the residuals, what it leaves.
  Eigen::VectorXd left(const BaseStep& step) const {
    return evidence_.r - columns_ * step + times(evidence_.U, along_ * step);
  }

 private:
  const TimeEvidence& evidence_;
  Eigen::MatrixXd columns_;
  Eigen::Matrix<double, kUnknowns, kUnknowns> gram_ = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Eigen::MatrixXd along_;  // U' times the columns
  BaseStep b_ = BaseStep::Zero();
};

/// Whether the stated noise explains residuals: along the beams, and across them.
bool explained(const TimeEvidence& evidence, const Eigen::VectorXd& left) {
  if (!evidence.noise_known) return false;
  double along2 = 0, degrees_along = 0;
  for (Eigen::Index row = 0; row < left.size(); row += 3) {
    const Eigen::Vector3d beam = evidence.beams.segment<3>(row);
    along2 += std::pow(beam.dot(left.segment<3>(row)), 2);
    degrees_along += 1 - (evidence.U.middleRows<3>(row).transpose() * beam).squaredNorm();
  }
  const double part_left = 1 - static_cast<double>(kUnknowns) / evidence.degrees;
  const auto fits = [=](double squares, double degrees) {
    return gamma_tail(squares / 2, part_left * degrees / 2) >= kSignificance;
  };
  return fits(along2, degrees_along) && fits(left.squaredNorm() - along2, evidence.degrees - degrees_along);
}

/// Chance at which columns explain so much where nothing moved: by a beta distribution, whatever the scale of
/// the noise, but that a stated one which explains what is left counts like so many residuals.
double chance(const TimeEvidence& evidence, const BaseColumns& columns, const BaseStep& step) {
  const double gain = columns.gain(step), left = std::max(0.0, evidence.r.squaredNorm() - gain);
  const int degrees_left = evidence.degrees - kUnknowns;
  const bool as_stated = explained(evidence, columns.left(step));
  if (!as_stated && left / degrees_left >= kHalved * kHalved * (left + gain) / evidence.degrees) return 1;
  const double stated = as_stated ? kStatedCounts : 0;
  const double gone = gain / (stated + left + gain), shape = (stated + degrees_left) / 2;
  return std::pow(1 - gone, shape) * (1 + shape * gone * (1 + (shape + 1) / 2 * gone));
}

struct PossibleMovement {
  Movement movement;
  double chance = 1;  ///< at which as much is seen where nothing moved
  double gain = 0;    ///< of the squares of the residuals, what it takes away
};

double mean_mm(const TimeEvidence& evidence, std::span<const std::size_t> points, const BaseStep& step) {
  double sum = 0;
  for (const std::size_t i : points) sum += (evidence.moves.middleRows<3>(row_of(i)) * step).norm();
  return sum / static_cast<double>(points.size());
}

/// Which of the points of a station may come after a step: the first of a pose, with enough poses before it
/// and from it on. What the arm does at one stop, all reflectors of that pose show.
///
/// @param pose  of each point
std::vector<bool> may_follow_step(std::span<const std::size_t> points, std::span<const int> pose) {
  std::vector<std::size_t> begins;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (k == 0 || pose[points[k]] != pose[points[k - 1]]) begins.push_back(k);
  std::vector<bool> may(points.size());
  for (std::size_t n = kFewest; n + kFewest <= begins.size(); ++n) may[begins[n]] = true;
  return may;
}

/// The step that explains the points of a station best.
///
/// @param pose     of each point
/// @param moments  of all stations
PossibleMovement best_step(const TimeEvidence& evidence, std::span<const std::size_t> points,
                           std::span<const int> pose, std::size_t moments) {
  const std::vector<bool> may_follow = may_follow_step(points, pose);
  BaseColumns after{evidence};
  std::size_t first = points.size();
  double most = 0;
  for (std::size_t k = points.size(); k-- > 0;) {
    after.add(points[k], 1);
    if (!may_follow[k]) continue;
    const double gain = after.gain(after.step());
    if (gain <= most) continue;
    most = gain;
    first = k;
  }
  BaseColumns best{evidence};
  for (const std::size_t i : points.subspan(first)) best.add(i, 1);
  if (first == points.size()) return {};
  const BaseStep step = best.step();
  return {{.first = points[first], .moved_mm = mean_mm(evidence, points.subspan(first), step)},
          static_cast<double>(moments) * chance(evidence, best, step),
          best.gain(step)};
}

/// The even movement that does.
PossibleMovement best_trend(const TimeEvidence& evidence, std::span<const std::size_t> points) {
  BaseColumns trend{evidence};
  for (std::size_t k = 0; k < points.size(); ++k)
    trend.add(points[k], static_cast<double>(k) / static_cast<double>(points.size() - 1));
  const BaseStep step = trend.step();
  return {
      {.moved_mm = mean_mm(evidence, points.last(1), step)}, chance(evidence, trend, step), trend.gain(step)};
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
    found->station = station;
    return found;
  }
  return std::nullopt;
}

/// The least likely of all movements by chance.
PossibleMovement best_candidate(const CalibratedCell& cell, const TimeEvidence& evidence,
                                std::span<const Measurement> points) {
  PossibleMovement best;
  const std::vector<int> pose = pose_numbers(points);
  for (int station = 0; station < cell.station_count(); ++station) {
    const std::vector<std::size_t> seen = seen_from(points, station);
    if (seen.size() < 2 * kFewest) continue;
    for (PossibleMovement each :
         {best_step(evidence, seen, pose, points.size()), best_trend(evidence, seen)}) {
      each.movement.station = station;
      if (each.chance < best.chance && each.movement.moved_mm >= kLeastMovement_mm) best = each;
    }
  }
  return best;
}

/// How well a movement explains the residuals, by Akaike's criterion; the moment of a step is an unknown too.
double criterion_of(const PossibleMovement& possible, const TimeEvidence& evidence) {
  const double left2 = std::max(0.0, evidence.r.squaredNorm() - possible.gain);
  return akaike_criterion(left2, evidence.degrees, possible.movement.first > 0 ? kUnknowns + 1 : kUnknowns);
}

}  // namespace

std::optional<Movement> movement(const CalibratedCell& cell, std::span<const Measurement> points,
                                 const std::optional<MeasurementNoise>& stated,
                                 std::span<const std::size_t> far) {
  std::vector<bool> is_far(points.size());
  for (const std::size_t i : far) is_far[i] = true;
  if (!far.empty()) {
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
  if (evidence.degrees <= kUnknowns) return std::nullopt;
  PossibleMovement best = best_candidate(cell, evidence, others);
  if (best.chance >= kByChance) return std::nullopt;
  const JointErrors joints = likeliest_joint_errors(cell, evidence, others);
  const double for_joints = criterion_of(best, evidence) - joints.criterion;
  if (for_joints > kOutOfQuestion) return std::nullopt;
  if (for_joints > -kOutOfQuestion) best.movement.or_joint = joints.joint;
  if (best.movement.first > 0) best.movement.first = number[best.movement.first];
  return best.movement;
}

}  // namespace truepose
