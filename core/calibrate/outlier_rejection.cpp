#include "core/calibrate/outlier_rejection.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <span>

#include "core/calibrate/identification.hpp"
#include "core/data/error_bounds.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/robust_fit.hpp"
#include "core/fit/target_turns.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/residual_distribution.hpp"

namespace truepose {
namespace {

constexpr double kGross = 6;             // standard deviations of one coordinate
constexpr double kLeastTurn_rad = 1e-6;  // less is rounding
/// Of the equations, what no parameter takes up. With less a fit comes so near that its own noise looks
/// gross.
constexpr double kLeastFreedom = 0.3;
constexpr std::size_t kFewestForTails = 200;  // points
constexpr double kByChance = 0.005;           // that any of the points of a sound campaign is as far
constexpr double kMostOfArm_mm = 3;           // what gears, bearings and loads do
constexpr double kSameWay = 0.5;              // of the longest error of a pose: how far its errors differ
constexpr double kNoWorse = 1.3;              // times what all others are left with

/// A point, and how far it is from what the judge predicts.
struct Distance {
  RejectedPoint point;
  Eigen::Vector3d error_mm;
};

/// How far the points of one set are from what the judge predicts, its own uncertainty included.
///
/// @param factor  of the judge's noise to the stated one
std::vector<Distance> distances(const Identification& judge, PoseSet set, double factor) {
  const MeasurementData& data = judge.data;
  const std::vector<Measurement> points = points_of(data, set);
  const Whitening whitening = whitening_of(points, judge.options.noise);
  Eigen::VectorXd errors;
  Eigen::MatrixXd J;
  residuals_with_jacobian(judge.fit.cell, points, errors, J);
  const std::vector<Eigen::Matrix3d> predicted = congruence_blocks(J, judge.uncertainty.covariance);
  const std::vector<std::optional<Eigen::Matrix3d>> R_FT =
      best_mountings(judge.fit.cell, judge.points.points(), judge.points.weighted_turns());
  const std::vector<Eigen::Vector3d> turns = target_turns(judge.fit.cell, points, R_FT);
  const std::vector<double> turn_lengths =
      turn_sigmas(judge.fit.cell, points, R_FT, judge.uncertainty.covariance, factor);
  std::vector<Distance> all;
  for (std::size_t k = 0; k < data.points.size(); ++k) {
    const Measurement& point = data.points[k];
    if (point.set != set) continue;
    const Eigen::Vector3d error_mm = errors.segment<3>(3 * static_cast<Eigen::Index>(all.size()));
    Eigen::Matrix3d W = Eigen::Matrix3d::Identity();
    if (!whitening.W.empty()) W = whitening.W[all.size()] / whitening.finest_mm;
    const Eigen::Matrix3d S =
        factor * factor * Eigen::Matrix3d::Identity() + W * predicted[all.size()] * W.transpose();
    const double length = (inverse_cholesky(S) * W * error_mm).norm(), turn = turn_lengths[all.size()];
    const double turned_rad = turn > length ? turns[all.size()].norm() : 0;
    all.push_back({{k, error_mm.norm(), std::max(length, turn), turned_rad}, error_mm});
  }
  return all;
}

/// Distances in what is usual among them, where the model is worse at all of them than it knows.
void divide_by_usual(std::vector<Distance>& all) {
  std::vector<double> lengths;
  for (const Distance& each : all) lengths.push_back(each.point.sigmas);
  const double usual = std::max(1.0, sigma_from_median(lengths));
  for (Distance& each : all) each.point.sigmas /= usual;
}

bool beyond_six_sigma(const Distance& of) {
  return of.point.sigmas > kGross &&
         (of.point.residual_mm > kLeastError_mm || of.point.turn_rad > kLeastTurn_rad);
}

/// The law by which the points to identify scatter that are within six sigma; nothing where they are too few
/// to show their tails.
std::optional<ResidualDistribution> residual_distribution_of(std::span<const Distance> identify) {
  std::vector<double> squares;
  for (const Distance& each : identify)
    if (!beyond_six_sigma(each)) squares.push_back(each.point.sigmas * each.point.sigmas);
  if (squares.size() < kFewestForTails) return std::nullopt;
  return ResidualDistribution{squares};
}

/// Points that stand out, and the errors of all.
struct FarPoints {
  std::vector<RejectedPoint> far;
  std::map<std::size_t, Eigen::Vector3d> errors_mm;  ///< by the points' index
};

FarPoints far_points(const Identification& judge) {
  FarPoints found;
  const int equations = judge.points.equations();
  if (equations - judge.result.rank < kLeastFreedom * equations) return found;
  const double stated_mm = whitening_of(judge.points.points(), judge.options.noise).finest_mm;
  const double sigma0_mm = judge.uncertainty.sigma0_mm;
  // What came nearer than the stated noise did so by chance.
  const double factor = stated_mm > 0 ? std::max(1.0, sigma0_mm / stated_mm) : sigma0_mm;
  std::optional<ResidualDistribution> distribution;
  for (const PoseSet set : {PoseSet::Identify, PoseSet::Validate}) {
    std::vector<Distance> all = distances(judge, set, factor);
    divide_by_usual(all);
    if (set == PoseSet::Identify) distribution = residual_distribution_of(all);
    for (const Distance& each : all) {
      found.errors_mm.emplace(each.point.point, each.error_mm);
      if (!beyond_six_sigma(each)) continue;
      // Of many points of an arm that errs with longer tails some are as far by chance.
      const Eigen::Vector3d whitened{each.point.sigmas, 0, 0};
      if (distribution && distribution->tail(whitened, 3) * static_cast<double>(all.size()) > kByChance)
        continue;
      found.far.push_back(each.point);
    }
  }
  std::ranges::sort(found.far, {}, &RejectedPoint::point);
  return found;
}

bool holds(std::span<const RejectedPoint> points, std::size_t index) {
  return std::ranges::count(points, index, &RejectedPoint::point) > 0;
}

/// Those of the far points to identify whose pose all its reflectors show off in the same way, by no more
/// than an arm errs: they contradict the model, and not each other.
std::vector<std::size_t> agreeing(const FarPoints& found, const MeasurementData& data) {
  std::vector<std::size_t> agree;
  for (const std::vector<std::size_t>& pose : pose_groups(data.points)) {
    if (data.points[pose.front()].set != PoseSet::Identify || pose.size() < 2) continue;
    const auto is_far = [&](std::size_t i) { return holds(found.far, i); };
    if (std::ranges::none_of(pose, is_far)) continue;
    double longest_mm = 0, apart_mm = 0;
    for (const std::size_t i : pose) {
      longest_mm = std::max(longest_mm, found.errors_mm.at(i).norm());
      for (const std::size_t j : pose)
        apart_mm = std::max(apart_mm, (found.errors_mm.at(i) - found.errors_mm.at(j)).norm());
    }
    if (longest_mm > kMostOfArm_mm || apart_mm > kSameWay * longest_mm) continue;
    std::ranges::copy_if(pose, std::back_inserter(agree), is_far);
  }
  return agree;
}

/// The judge of all points, with all layers that it may find.
std::optional<FarPoints> judged(Identification& judge) {
  if (fit_base_and_reflectors(judge) || fit_geometry(judge) || fit_deviations(judge)) return std::nullopt;
  return far_points(judge);
}

/// Without those that a model explains which was fitted with them, and which is no worse at all others.
std::vector<RejectedPoint> unexplained(std::vector<RejectedPoint> far, const std::vector<std::size_t>& agree,
                                       const Identification& judge) {
  std::vector<RejectedPoint> single = far;
  std::erase_if(single,
                [&](const RejectedPoint& point) { return std::ranges::count(agree, point.point) > 0; });
  std::erase_if(single, [&](const RejectedPoint& point) {
    return judge.data.points[point.point].set == PoseSet::Validate;
  });
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < judge.data.points.size(); ++i)
    if (!holds(single, i)) index.push_back(i);
  const MeasurementData others = without(single, judge.data);
  CalibrateOptions options = judge.options;
  options.loss = Loss::Squared;
  Identification with(judge.nominal, others, options);
  const auto found = judged(with);
  if (!found || with.uncertainty.sigma0_mm > kNoWorse * judge.uncertainty.sigma0_mm) return far;
  for (RejectedPoint point : found->far) {
    point.point = index[point.point];
    single.push_back(point);
  }
  std::ranges::sort(single, {}, &RejectedPoint::point);
  return single;
}

}  // namespace

std::vector<RejectedPoint> find_outliers(const RobotModel& nominal, const MeasurementData& data,
                                         const CalibrateOptions& options) {
  CalibrateOptions judging = options;
  judging.loss = Loss::Tukey;
  judging.non_geometric = true;
  Identification judge(nominal, data, judging);
  if (fit_base_and_reflectors(judge) || fit_geometry(judge)) return {};
  // What the geometry alone finds near, no richer model needs to look at.
  const FarPoints by_geometry = far_points(judge);
  if (by_geometry.far.empty() || fit_deviations(judge)) return {};
  const FarPoints found = far_points(judge);
  std::vector<RejectedPoint> far = found.far;
  if (const auto agree = agreeing(found, data); !agree.empty()) far = unexplained(far, agree, judge);
  // A model without deviations is not judged by what they see.
  if (!options.non_geometric)
    std::erase_if(far, [&](const RejectedPoint& point) { return !holds(by_geometry.far, point.point); });
  return far;
}

MeasurementData without(std::span<const RejectedPoint> points, const MeasurementData& data) {
  MeasurementData others{.smr_names = data.smr_names, .points = {}, .stations = data.stations};
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    if (std::ranges::count(points, i, &RejectedPoint::point) == 0) others.points.push_back(data.points[i]);
  }
  return others;
}

}  // namespace truepose
