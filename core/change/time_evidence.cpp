#include "core/change/time_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/fit/identifiability.hpp"
#include "core/fit/measured_order.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Orthonormal columns that span those of A.
Eigen::MatrixXd span_of(const Eigen::MatrixXd& A) {
  const Svd svd = thin_svd(A * column_norms(A).cwiseInverse().asDiagonal());
  return svd.U.leftCols((svd.s.array() > kRankTolerance * svd.s[0]).count());
}

/// Rows of a stop's points as their mean, times the root of their number, and their differences: where the
/// arm stands a little off, all points of the stop show it alike, and so in the mean alone. Source: Helmert's
/// transformation, which is orthogonal.
///
/// @param rows  three of each point
void take_apart(Eigen::Ref<Eigen::MatrixXd> rows) {
  const Eigen::MatrixXd of_points = rows;
  const Eigen::Index points = rows.rows() / 3;
  Eigen::MatrixXd sum = of_points.topRows<3>();
  for (Eigen::Index k = 1; k < points; ++k) {
    const auto before = static_cast<double>(k);
    rows.middleRows<3>(3 * k) =
        (sum - before * of_points.middleRows<3>(3 * k)) / std::sqrt(before * (before + 1));
    sum += of_points.middleRows<3>(3 * k);
  }
  rows.topRows<3>() = sum / std::sqrt(static_cast<double>(points));
}

/// Whitens the rows of each stop, taken apart.
void whiten(std::span<const Measurement> points, const MeasurementNoise& noise, Eigen::VectorXd& f,
            Eigen::MatrixXd& J) {
  MeasurementNoise of_tracker = noise;
  of_tracker.repeatability_mm = 0;
  for (const std::vector<std::size_t>& stop : stops_of(points)) {
    const Eigen::Index first = row_of(stop.front()), count = 3 * std::ssize(stop);
    take_apart(J.middleRows(first, count));
    Eigen::MatrixXd residuals = f.segment(first, count);
    take_apart(residuals);
    f.segment(first, count) = residuals;
    for (std::size_t k = 0; k < stop.size(); ++k) {
      Measurement point = points[stop[k]];
      if (k == 0)
        point.excess_mm =
            std::hypot(point.excess_mm, noise.repeatability_mm * std::sqrt(static_cast<double>(stop.size())));
      const Eigen::Matrix3d W = inverse_cholesky(point_covariance(point, of_tracker));
      f.segment<3>(row_of(stop[k])) = W * f.segment<3>(row_of(stop[k])).eval();
      J.middleRows<3>(row_of(stop[k])) = W * J.middleRows<3>(row_of(stop[k])).eval();
    }
  }
}

/// The same of points that state their own noise, or of which none is known.
void whiten(const Whitening& whitening, Eigen::VectorXd& f, Eigen::MatrixXd& J) {
  for (std::size_t i = 0; i < whitening.W.size(); ++i) {
    const Eigen::Index row = row_of(i);
    const Eigen::Matrix3d W = whitening.W[i] / whitening.finest_mm;
    f.segment<3>(row) = W * f.segment<3>(row).eval();
    J.middleRows<3>(row) = W * J.middleRows<3>(row).eval();
  }
}

bool states_a_trackers_noise(std::span<const Measurement> points,
                             const std::optional<MeasurementNoise>& stated) {
  if (!stated || std::ranges::all_of(points, [](const Measurement& m) { return m.sigma_mm.has_value(); }))
    return false;
  const TrackerNoiseModel& tracker = stated->tracker;
  return tracker.range_mm + tracker.range_mm_per_m > 0 &&
         tracker.transverse_mm + tracker.transverse_mm_per_m > 0;
}

}  // namespace

TimeEvidence time_evidence(const CalibratedCell& cell, std::span<const Measurement> points,
                           const std::optional<MeasurementNoise>& stated) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  TimeEvidence evidence{.moves = J, .J = {}, .U = {}, .r = {}, .beams = Eigen::VectorXd(f.size())};
  const Whitening whitening = whitening_of(points, stated);
  evidence.noise_known = !whitening.W.empty();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Matrix3d W = Eigen::Matrix3d::Identity();
    if (evidence.noise_known) W = whitening.W[i] / whitening.finest_mm;
    evidence.beams.segment<3>(row_of(i)) = (W * points[i].p_WS_mm).normalized();
  }
  if (states_a_trackers_noise(points, stated))
    whiten(points, *stated, f, J);
  else
    whiten(whitening, f, J);
  evidence.U = span_of(J);
  evidence.r = times(evidence.U, transposed_times(evidence.U, f)) - f;
  evidence.degrees = static_cast<int>(f.size() - evidence.U.cols());
  evidence.J = std::move(J);
  return evidence;
}

}  // namespace truepose
