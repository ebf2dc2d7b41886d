#include "core/judge/time_evidence.hpp"

#include <cmath>
#include <utility>

#include "core/identify/identifiability.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Orthonormal columns that span those of A.
Eigen::MatrixXd span_of(const Eigen::MatrixXd& A) {
  const Svd svd = thin_svd(A * column_norms(A).cwiseInverse().asDiagonal());
  return svd.U.leftCols((svd.s.array() > kRankTolerance * svd.s[0]).count());
}

/// What the arm does at one stop, all reflectors of that pose show: together they tell no more of it than one
/// does, as if each were blurred by so much more.
std::vector<Measurement> blurred_alike(std::span<const Measurement> points, double repeatability_mm) {
  std::vector<Measurement> blurred(points.begin(), points.end());
  for (const std::vector<std::size_t>& pose : pose_groups(points)) {
    const double more_mm = repeatability_mm * std::sqrt(static_cast<double>(pose.size()) - 1);
    for (const std::size_t i : pose) blurred[i].excess_mm = std::hypot(points[i].excess_mm, more_mm);
  }
  return blurred;
}

}  // namespace

TimeEvidence time_evidence(const CalibratedCell& cell, std::span<const Measurement> points,
                           const std::optional<MeasurementNoise>& stated) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  TimeEvidence evidence{.moves = J, .J = {}, .U = {}, .r = {}, .beams = Eigen::VectorXd(f.size())};
  const Whitening whitening =
      whitening_of(blurred_alike(points, stated ? stated->repeatability_mm : 0), stated);
  evidence.noise_known = !whitening.W.empty();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Index row = row_of(i);
    Eigen::Matrix3d W = Eigen::Matrix3d::Identity();
    if (evidence.noise_known) W = whitening.W[i] / whitening.finest_mm;
    f.segment<3>(row) = W * f.segment<3>(row).eval();
    J.middleRows<3>(row) = W * J.middleRows<3>(row).eval();
    evidence.beams.segment<3>(row) = (W * points[i].p_WS_mm).normalized();
  }
  evidence.U = span_of(J);
  evidence.r = times(evidence.U, transposed_times(evidence.U, f)) - f;
  evidence.degrees = static_cast<int>(f.size() - evidence.U.cols());
  evidence.J = std::move(J);
  return evidence;
}

}  // namespace truepose
