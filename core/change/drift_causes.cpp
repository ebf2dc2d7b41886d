#include "core/change/drift_causes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/identifiability.hpp"
#include "core/fit/least_squares_problem.hpp"
#include "core/fit/measured_order.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/residual_distribution.hpp"

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

namespace {

constexpr int kFewestLeft = 3;                      // equations that have to be left to check a cause by
const double kNearlyAsLikely = 2 * std::log(20.0);  // Kass, Raftery, JASA 90 (1995): strong evidence

/// Every change that points might show, of the cell first.
std::vector<PossibleChange> candidates(const CalibratedCell& cell, std::span<const Measurement> points) {
  std::vector<PossibleChange> all = shown_changes(cell, points);
  std::ranges::copy(wrong_readings(points), std::back_inserter(all));
  return all;
}

struct LinearFit {
  Eigen::VectorXd x, sigma;
  Eigen::VectorXd left;  ///< A x - b
  int rank = 0;
};

LinearFit linear_fit(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::VectorXd scale = column_norms(A).cwiseInverse();
  const Svd svd = thin_svd(A * scale.asDiagonal());
  LinearFit found;
  found.rank = static_cast<int>((svd.s.array() > kRankTolerance * svd.s[0]).count());
  const Eigen::MatrixXd V =
      scale.asDiagonal() * svd.V.leftCols(found.rank) * svd.s.head(found.rank).cwiseInverse().asDiagonal();
  found.x = times(V, transposed_times(svd.U.leftCols(found.rank), b));
  found.sigma = V.rowwise().norm();
  found.left = times(A, found.x) - b;
  return found;
}

/// What all causes are fitted to.
struct Observed {
  const DriftReference& reference;
  std::span<const Measurement> points;
  DriftResiduals at_reference;
};

std::optional<Observed> observed(const DriftReference& reference, std::span<const Measurement> points) {
  auto residuals = drift_residuals(reference, reference.cell, points);
  if (!residuals) return std::nullopt;
  return Observed{reference, points, *std::move(residuals)};
}

/// A fitted cause and the cell in which it is corrected (of a reading: the reference).
struct Fitted {
  DriftCause cause;
  CalibratedCell cell;
};

/// Gauss-Newton over the parameters of the cause; a reading is linear, and corrects itself whole.
std::optional<Fitted> fitted(const PossibleChange& candidate, const Observed& seen) {
  constexpr int kMaxSteps = 20;
  constexpr double kDone = 1e-6;  // standard deviations
  const DriftReference& reference = seen.reference;
  const std::span<const Measurement> points = seen.points;
  const bool reading = candidate.what.kind == ChangeKind::Reading;
  const bool base = candidate.what.kind == ChangeKind::Base;
  CalibratedCell cell = base ? with_fitted_base(reference.cell, points) : reference.cell;
  std::optional<DriftResiduals> elsewhere;
  LinearFit found;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (base || step > 0) {
      auto residuals = drift_residuals(reference, cell, points);
      if (!residuals) return std::nullopt;
      elsewhere = *std::move(residuals);
    }
    const DriftResiduals& here = elsewhere ? *elsewhere : seen.at_reference;
    const Eigen::MatrixXd A = reading ? Eigen::MatrixXd(here.inverse.middleCols<3>(3 * candidate.what.index))
                                      : Eigen::MatrixXd(here.J(Eigen::all, candidate.free));
    found = linear_fit(A, here.r);
    if (reading || times(A, found.x).norm() < kDone) break;
    move_by(cell, scattered(found.x, candidate.free, ParameterLayout::of(cell).size()));
  }
  const auto equations = 3 * static_cast<int>(points.size());
  if (found.rank == 0 || equations - found.rank < kFewestLeft || !found.left.allFinite()) return std::nullopt;
  DriftCause cause{.what = candidate.what,
                   .moved = reading ? found.x : moved_between(reference.cell, cell, candidate.what),
                   .sigma = found.sigma,
                   .distance2 = found.left.squaredNorm(),
                   .degrees = equations - found.rank};
  cause.probability = ResidualDistribution(reference.validation_distances2)
                          .tail(found.left, cause.degrees, points_per_stop(points));
  cause.score = cause.distance2 + found.rank * std::log(equations);
  return Fitted{std::move(cause), std::move(cell)};
}

/// The points as they would be had nothing but this cause happened.
std::vector<Measurement> points_after(const Fitted& fitted, std::span<const Measurement> points) {
  std::vector<Measurement> after(points.begin(), points.end());
  for (Measurement& point : after) point.p_WS_mm = fitted.cell.predict(point);
  if (fitted.cause.what.kind == ChangeKind::Reading)
    after[static_cast<std::size_t>(fitted.cause.what.index)].p_WS_mm += fitted.cause.moved;
  return after;
}

}  // namespace

DriftDiagnosis diagnose_drift(const DriftReference& reference, std::span<const Measurement> points) {
  struct Hypothesis {
    PossibleChange candidate;
    Fitted fit;
  };
  std::vector<Hypothesis> all;
  const auto seen = observed(reference, points);
  if (!seen) return {};
  for (PossibleChange& candidate : candidates(reference.cell, points)) {
    if (auto fit = fitted(candidate, *seen)) all.push_back({std::move(candidate), *std::move(fit)});
  }
  std::ranges::stable_sort(
      all, {}, [](const Hypothesis& h) { return std::pair(!h.fit.cause.explains(), h.fit.cause.score); });

  if (all.empty()) return {};
  const std::vector<Measurement> after = points_after(all.front().fit, points);
  const auto seen_after = observed(reference, after);
  DriftDiagnosis diagnosis;
  for (const Hypothesis& h : all) {
    const DriftCause &cause = h.fit.cause, &first = all.front().fit.cause;
    diagnosis.causes.push_back(cause);
    if (&cause == &first || !cause.explains()) continue;
    const auto imitation = seen_after ? fitted(h.candidate, *seen_after) : std::nullopt;
    const bool does_the_same = imitation && imitation->cause.distance2 < 1;  // one sigma
    if (does_the_same || cause.score - first.score < kNearlyAsLikely) diagnosis.alternatives.push_back(cause);
  }
  return diagnosis;
}

std::string described(const DriftCause& cause, const CalibratedCell& cell,
                      std::span<const Measurement> points) {
  return described(cause.what, cause.moved, cell, points);
}

std::string remedy(const DriftCause& cause) {
  switch (cause.what.kind) {
    case ChangeKind::Base:
      return "fit the frame again";
    case ChangeKind::Reflector:
      return "fasten it and fit its place on the flange again";
    case ChangeKind::JointZero:
      return "check the axis's mastering, then calibrate again";
    case ChangeKind::Growth:
      return "measure when the arm is as warm as it was";
    case ChangeKind::Link:
    case ChangeKind::AllZeros:
    case ChangeKind::Load:
      return "calibrate again";
    case ChangeKind::Reading:
      return "measure that point again";
  }
  return {};
}

}  // namespace truepose
