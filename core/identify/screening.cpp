#include "core/identify/screening.hpp"

#include <algorithm>
#include <span>

#include "core/identify/error_bounds.hpp"
#include "core/identify/identification.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/identify/robust_fit.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr double kGross = 6;  // standard deviations of one coordinate
/// Of the equations, what no parameter takes up. With less a fit comes so near that its own noise looks
/// gross.
constexpr double kLeastFreedom = 0.3;

/// How far the points of one set are from what the judge predicts, its own uncertainty included.
///
/// @param factor  of the judge's noise to the stated one
std::vector<RejectedPoint> distances(const Identification& judge, PoseSet set, double factor) {
  const MeasurementData& data = judge.data;
  const std::vector<Measurement> points = points_of(data, set);
  const Whitening whitening = whitening_of(points, judge.options.noise);
  Eigen::VectorXd errors;
  Eigen::MatrixXd J;
  residuals_with_jacobian(judge.fit.cell, points, errors, J);
  const std::vector<Eigen::Matrix3d> predicted = congruence_blocks(J, judge.uncertainty.covariance);
  std::vector<RejectedPoint> all;
  for (std::size_t k = 0; k < data.points.size(); ++k) {
    const Measurement& point = data.points[k];
    if (point.set != set) continue;
    const Eigen::Vector3d error_mm = errors.segment<3>(3 * static_cast<Eigen::Index>(all.size()));
    Eigen::Matrix3d W = Eigen::Matrix3d::Identity();
    if (!whitening.W.empty()) W = whitening.W[all.size()] / whitening.finest_mm;
    const Eigen::Matrix3d S =
        factor * factor * Eigen::Matrix3d::Identity() + W * predicted[all.size()] * W.transpose();
    all.push_back({k, error_mm.norm(), (inverse_cholesky(S) * W * error_mm).norm()});
  }
  return all;
}

/// Appends those that stand out. Where the model is worse at all of them than it knows, they are judged by
/// what is usual among them.
void add_far(std::vector<RejectedPoint> points, std::vector<RejectedPoint>& far) {
  std::vector<double> lengths;
  for (const RejectedPoint& point : points) lengths.push_back(point.sigmas);
  const double usual = std::max(1.0, sigma_from_median(lengths));
  for (RejectedPoint& point : points) {
    point.sigmas /= usual;
    if (point.sigmas > kGross && point.residual_mm > kLeastError_mm) far.push_back(point);
  }
}

std::vector<RejectedPoint> far_points(const Identification& judge) {
  const int equations = judge.points.equations();
  if (equations - judge.result.rank < kLeastFreedom * equations) return {};
  const double stated_mm = whitening_of(judge.points.points(), judge.options.noise).finest_mm;
  const double sigma0_mm = judge.uncertainty.sigma0_mm;
  // What came nearer than the stated noise did so by chance.
  const double factor = stated_mm > 0 ? std::max(1.0, sigma0_mm / stated_mm) : sigma0_mm;
  std::vector<RejectedPoint> far;
  for (const PoseSet set : {PoseSet::Identify, PoseSet::Validate})
    add_far(distances(judge, set, factor), far);
  std::ranges::sort(far, {}, &RejectedPoint::point);
  return far;
}

}  // namespace

std::vector<RejectedPoint> gross_errors(const RobotModel& nominal, const MeasurementData& data,
                                        const CalibrateOptions& options) {
  CalibrateOptions judging = options;
  judging.method = CalibrationMethod::TwoStage;
  judging.loss = Loss::Tukey;
  judging.deviation = true;
  Identification judge(nominal, data, judging);
  if (fit_base_and_reflectors(judge) || fit_geometry(judge)) return {};
  // What the geometry alone finds near, no richer model needs to look at.
  if (far_points(judge).empty() || fit_deviations(judge)) return {};
  return far_points(judge);
}

MeasurementData without(std::span<const RejectedPoint> points, const MeasurementData& data) {
  MeasurementData others{.smr_names = data.smr_names, .points = {}, .stations = data.stations};
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    if (std::ranges::count(points, i, &RejectedPoint::point) == 0) others.points.push_back(data.points[i]);
  }
  return others;
}

}  // namespace truepose
