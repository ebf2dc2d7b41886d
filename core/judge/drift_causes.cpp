#include "core/judge/drift_causes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/identifiability.hpp"
#include "core/identify/least_squares_problem.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/rigid_fit.hpp"
#include "core/math/statistics.hpp"

namespace truepose {

std::expected<DriftResiduals, std::string> drift_residuals(const DriftReference& reference,
                                                           const CalibratedCell& cell,
                                                           std::span<const Measurement> points) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(f.size(), f.size());
  if (reference.covariance.size() > 0) S = congruence(J, reference.covariance);
  Eigen::Index row = 0;
  for (const Measurement& point : points) {
    S.block<3, 3>(row, row) += reading_covariance(point.p_WS_mm, reference.noise);
    row += 3;
  }
  const CholeskyFactor factor(S);
  if (!factor.succeeded())
    return std::unexpected("the noise of a point must be above 0 and the model's covariance not negative");
  const Eigen::MatrixXd inverse = factor.inverse_lower();
  return DriftResiduals{
      .r = -times(inverse, f), .J = times(inverse, J), .inverse = inverse, .S = std::move(S)};
}

namespace {

constexpr int kFewestLeft = 3;                      // equations that have to be left to check a cause by
constexpr int kFewestToOutvote = 3;                 // of which two may call the third wrong
const double kNearlyAsLikely = 2 * std::log(20.0);  // Kass, Raftery, JASA 90 (1995): strong evidence

/// A possible cause before it is fitted.
struct Candidate {
  DriftCauseKind kind;
  int index;
  std::vector<int> free;  ///< parameters that it moves; none for a reading
};

std::vector<Candidate> candidates(const CalibratedCell& cell, std::span<const Measurement> points) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<Candidate> all{{DriftCauseKind::Base, 0, {0, 1, 2, 3, 4, 5}}};
  for (int k = 0; k < layout.reflectors; ++k) {
    if (std::ranges::find(points, k, &Measurement::smr) == points.end()) continue;
    const int first = layout.reflector(k);
    all.push_back({DriftCauseKind::Reflector, k, {first, first + 1, first + 2}});
  }
  for (int i = 0; i < layout.joints; ++i) {
    const bool turns = cell.robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    all.push_back({DriftCauseKind::JointZero, i, {layout.link(i) + (turns ? 3 : 2)}});  // theta or d
  }
  const auto count = static_cast<int>(points.size());
  for (int n = 0; n < count && count >= kFewestToOutvote; ++n)
    all.push_back({DriftCauseKind::Reading, n, {}});
  return all;
}

struct LinearFit {
  Eigen::VectorXd x, sigma;
  double left = 0;  ///< |A x - b|^2
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
  found.left = (times(A, found.x) - b).squaredNorm();
  return found;
}

/// A fitted cause and the cell in which it is corrected (of a reading: the reference).
struct Fitted {
  DriftCause cause;
  CalibratedCell cell;
};

/// A tracker may have been set up anew anywhere, so that the base is sought by a rigid fit first.
CalibratedCell start_of(const Candidate& candidate, const CalibratedCell& cell,
                        std::span<const Measurement> points) {
  if (candidate.kind != DriftCauseKind::Base) return cell;
  std::vector<Eigen::Vector3d> predicted, measured;
  for (const Measurement& point : points) {
    predicted.push_back(cell.predict(point.q, point.smr, point.direction));
    measured.push_back(point.p_WS_mm);
  }
  CalibratedCell start = cell;
  if (const auto X = rigid_fit(predicted, measured)) start.base = BasePose::of(*X * cell.base.isometry());
  return start;
}

/// What moved from one cell to another, in the terms of DriftCause.
Eigen::VectorXd moved_between(const CalibratedCell& from, const CalibratedCell& to,
                              const Candidate& candidate) {
  const auto index = static_cast<std::size_t>(candidate.index);
  if (candidate.kind == DriftCauseKind::Base) {
    Eigen::VectorXd moved(6);
    moved << to.base.p_mm - from.base.p_mm,
        turn_between(from.base.isometry().linear(), to.base.isometry().linear());
    return moved;
  }
  if (candidate.kind == DriftCauseKind::Reflector)
    return to.reflectors[index].p_FS_mm - from.reflectors[index].p_FS_mm;
  const Joint &before = from.robot.joints[index], &after = to.robot.joints[index];
  const double way =
      before.type == JointType::Revolute ? after.theta_rad - before.theta_rad : after.d_mm - before.d_mm;
  return Eigen::VectorXd::Constant(1, before.sign * way);
}

/// Gauss-Newton over the parameters of the cause; a reading is linear, and corrects itself whole.
std::optional<Fitted> fitted(const Candidate& candidate, const DriftReference& reference,
                             std::span<const Measurement> points) {
  constexpr int kMaxSteps = 20;
  constexpr double kDone = 1e-6;  // standard deviations
  CalibratedCell cell = start_of(candidate, reference.cell, points);
  LinearFit found;
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto residuals = drift_residuals(reference, cell, points);
    if (!residuals) return std::nullopt;
    const bool reading = candidate.kind == DriftCauseKind::Reading;
    const Eigen::MatrixXd A = reading ? Eigen::MatrixXd(residuals->inverse.middleCols<3>(3 * candidate.index))
                                      : Eigen::MatrixXd(residuals->J(Eigen::all, candidate.free));
    found = linear_fit(A, residuals->r);
    if (reading || times(A, found.x).norm() < kDone) break;
    move_by(cell, scattered(found.x, candidate.free, ParameterLayout::of(cell).size()));
  }
  const auto equations = 3 * static_cast<int>(points.size());
  if (found.rank == 0 || equations - found.rank < kFewestLeft || !std::isfinite(found.left))
    return std::nullopt;
  DriftCause cause{.kind = candidate.kind,
                   .index = candidate.index,
                   .moved = candidate.kind == DriftCauseKind::Reading
                                ? found.x
                                : moved_between(reference.cell, cell, candidate),
                   .sigma = found.sigma,
                   .distance2 = found.left,
                   .degrees = equations - found.rank};
  cause.probability = chi_square_tail(cause.distance2, cause.degrees);
  cause.score = cause.distance2 + found.rank * std::log(equations);
  return Fitted{std::move(cause), std::move(cell)};
}

/// The points as they would be had nothing but this cause happened.
std::vector<Measurement> points_after(const Fitted& fitted, std::span<const Measurement> points) {
  std::vector<Measurement> after(points.begin(), points.end());
  for (Measurement& point : after) point.p_WS_mm = fitted.cell.predict(point.q, point.smr, point.direction);
  if (fitted.cause.kind == DriftCauseKind::Reading)
    after[static_cast<std::size_t>(fitted.cause.index)].p_WS_mm += fitted.cause.moved;
  return after;
}

std::string formatted(const char* format, double a, double b = 0) {
  char text[96];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

DriftDiagnosis diagnose_drift(const DriftReference& reference, std::span<const Measurement> points) {
  struct Hypothesis {
    Candidate candidate;
    Fitted fit;
  };
  std::vector<Hypothesis> all;
  for (Candidate& candidate : candidates(reference.cell, points)) {
    if (auto fit = fitted(candidate, reference, points))
      all.push_back({std::move(candidate), *std::move(fit)});
  }
  std::ranges::stable_sort(
      all, {}, [](const Hypothesis& h) { return std::pair(!h.fit.cause.explains(), h.fit.cause.score); });

  DriftDiagnosis diagnosis;
  for (const Hypothesis& h : all) {
    const DriftCause &cause = h.fit.cause, &first = all.front().fit.cause;
    diagnosis.causes.push_back(cause);
    if (&cause == &first || !cause.explains()) continue;
    const auto imitation = fitted(h.candidate, reference, points_after(all.front().fit, points));
    const bool does_the_same = imitation && imitation->cause.distance2 < 1;  // one sigma
    if (does_the_same || cause.score - first.score < kNearlyAsLikely) diagnosis.alternatives.push_back(cause);
  }
  return diagnosis;
}

std::string described(const DriftCause& cause, const CalibratedCell& cell,
                      std::span<const Measurement> points) {
  const auto index = static_cast<std::size_t>(cause.index);
  switch (cause.kind) {
    case DriftCauseKind::Base:
      return formatted("the tracker or the base moved by %.2f mm and %.4f deg", cause.moved.head<3>().norm(),
                       cause.moved.tail<3>().norm() * kDegPerRad);
    case DriftCauseKind::Reflector:
      return "reflector '" + cell.reflectors[index].name + "' moved on the flange by " +
             formatted("%.2f mm", cause.moved.norm());
    case DriftCauseKind::JointZero:
      return "axis " + std::to_string(cause.index + 1) + "'s zero moved by " +
             (cell.robot.joints[index].type == JointType::Revolute
                  ? formatted("%.4f deg", cause.moved[0] * kDegPerRad)
                  : formatted("%.3f mm", cause.moved[0]));
    case DriftCauseKind::Reading: {
      const int row = points[index].row > 0 ? points[index].row : cause.index + 1;
      return "the reading of point " + std::to_string(row) + " alone is off by " +
             formatted("%.2f mm", cause.moved.norm());
    }
  }
  return {};
}

std::string remedy(const DriftCause& cause) {
  switch (cause.kind) {
    case DriftCauseKind::Base:
      return "fit the frame again";
    case DriftCauseKind::Reflector:
      return "fasten it and fit its place on the flange again";
    case DriftCauseKind::JointZero:
      return "check the axis's mastering, then calibrate again";
    case DriftCauseKind::Reading:
      return "measure that point again";
  }
  return {};
}

}  // namespace truepose
