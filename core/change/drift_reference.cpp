#include "core/change/drift_reference.hpp"

#include "core/fit/least_squares_problem.hpp"
#include "core/fit/measured_order.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {

namespace {

bool usable(const CalibratedCell& cell, const Measurement& point) {
  return point.q.size() == cell.robot.joint_count() && point.q.allFinite() && point.p_WS_mm.allFinite();
}

/// Part of the arm's variance that all reflectors show alike at one stop: the rest turns the flange.
constexpr double kSharedAtStop = 0.8;

/// Where the tracker's noise is known: else nothing says which part of all is the arm's.
void add_what_stops_share(std::span<const Measurement> points, const MeasurementNoise& noise,
                          Eigen::MatrixXd& S) {
  const TrackerNoiseModel& tracker = noise.tracker;
  if (tracker.range_mm + tracker.range_mm_per_m + tracker.transverse_mm + tracker.transverse_mm_per_m <= 0)
    return;
  const double shared = kSharedAtStop * noise.repeatability_mm * noise.repeatability_mm;
  for (const std::vector<std::size_t>& stop : stops_of(points))
    for (const std::size_t i : stop)
      for (const std::size_t j : stop)
        if (i != j)
          S.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j))
              .diagonal()
              .array() += shared;
}

}  // namespace

std::expected<DriftResiduals, std::string> drift_residuals(const DriftReference& reference,
                                                           const CalibratedCell& cell,
                                                           std::span<const Measurement> points) {
  if (points.empty()) return std::unexpected("no point to check the model by");
  for (const Measurement& point : points) {
    if (usable(cell, point)) continue;
    return std::unexpected("row " + std::to_string(point.row) + " holds a number that is not finite");
  }
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(f.size(), f.size());
  if (reference.covariance.size() > 0) S = congruence(J, reference.covariance);
  Eigen::Index row = 0;
  for (const Measurement& point : points) {
    S.block<3, 3>(row, row) += point_covariance(point, reference.noise);
    row += 3;
  }
  add_what_stops_share(points, reference.noise, S);
  const CholeskyFactor factor(S);
  if (!factor.succeeded())
    return std::unexpected("the noise of a point must be above 0 and the model's covariance not negative");
  const Eigen::MatrixXd inverse = factor.inverse_lower();
  return DriftResiduals{
      .r = -times(inverse, f), .J = times(inverse, J), .inverse = inverse, .S = std::move(S)};
}

std::expected<std::vector<double>, std::string> point_distances2(const DriftReference& reference,
                                                                 std::span<const Measurement> points) {
  std::vector<double> distances2;
  for (const Measurement& point : points) {
    const auto residuals = drift_residuals(reference, reference.cell, std::span(&point, 1));
    if (!residuals) return std::unexpected(residuals.error());
    distances2.push_back(residuals->r.squaredNorm());
  }
  return distances2;
}

}  // namespace truepose
