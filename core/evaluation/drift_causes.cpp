#include "core/evaluation/drift_causes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/calibration/identifiability.hpp"
#include "core/calibration/parameters.hpp"
#include "core/evaluation/chi_square.hpp"
#include "core/kinematics/angles.hpp"
#include "core/linear_algebra/decompositions.hpp"

namespace truepose {
namespace {

constexpr int kFewestLeft = 3;                      // equations that have to be left to check a cause by
constexpr int kFewestToOutvote = 3;                 // of which two may call the third wrong
const double kNearlyAsLikely = 2 * std::log(20.0);  // Kass, Raftery, JASA 90 (1995): strong evidence

/// A possible cause before it is fitted: what a unit of each unknown does to the whitened residuals.
struct Candidate {
  DriftCauseKind kind;
  int index;
  Eigen::MatrixXd A;
};

std::vector<Candidate> candidates(const CalibratedCell& cell, std::span<const Measurement> points,
                                  const WhitenedResiduals& residuals) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<Candidate> all{{DriftCauseKind::Base, 0, residuals.J.leftCols<ParameterLayout::kBase>()}};
  for (int k = 0; k < layout.reflectors; ++k) {
    if (std::ranges::find(points, k, &Measurement::smr) == points.end()) continue;
    all.push_back({DriftCauseKind::Reflector, k, residuals.J.middleCols<3>(layout.reflector(k))});
  }
  for (int i = 0; i < layout.joints; ++i) {
    const Joint& joint = cell.robot.joints[static_cast<std::size_t>(i)];
    const int column = layout.link(i) + (joint.type == JointType::Revolute ? 3 : 2);  // theta or d
    all.push_back({DriftCauseKind::JointZero, i, joint.sign * residuals.J.col(column)});
  }
  const auto count = static_cast<int>(points.size());
  for (int n = 0; n < count && count >= kFewestToOutvote; ++n) {
    all.push_back({DriftCauseKind::Reading, n, residuals.inverse.middleCols<3>(3 * n)});
  }
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
  found.x = V * (svd.U.leftCols(found.rank).transpose() * b);
  found.sigma = V.rowwise().norm();
  found.left = (A * found.x - b).squaredNorm();
  return found;
}

/// The fitted cause, or nothing where it leaves nothing to check it by.
std::optional<DriftCause> fitted(const Candidate& candidate, const Eigen::VectorXd& r) {
  const LinearFit found = linear_fit(candidate.A, r);
  const auto equations = static_cast<int>(r.size());
  if (found.rank == 0 || equations - found.rank < kFewestLeft) return std::nullopt;
  DriftCause cause{.kind = candidate.kind,
                   .index = candidate.index,
                   .moved = found.x,
                   .sigma = found.sigma,
                   .distance2 = found.left,
                   .degrees = equations - found.rank};
  cause.probability = chi_square_tail(cause.distance2, cause.degrees);
  cause.score = cause.distance2 + found.rank * std::log(equations);
  return cause;
}

std::string formatted(const char* format, double a, double b = 0) {
  char text[96];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

DriftDiagnosis diagnose_drift(const CalibratedCell& cell, std::span<const Measurement> points,
                              const WhitenedResiduals& residuals) {
  struct Fitted {
    DriftCause cause;
    Eigen::MatrixXd A;
  };
  std::vector<Fitted> all;
  for (Candidate& candidate : candidates(cell, points, residuals)) {
    if (auto cause = fitted(candidate, residuals.r))
      all.push_back({*std::move(cause), std::move(candidate.A)});
  }
  std::ranges::stable_sort(all, {},
                           [](const Fitted& f) { return std::pair(!f.cause.explains(), f.cause.score); });

  DriftDiagnosis diagnosis;
  for (const Fitted& f : all) {
    diagnosis.causes.push_back(f.cause);
    const Fitted& first = all.front();
    if (&f == &first || !f.cause.explains()) continue;
    const bool nearly_as_likely = f.cause.score - first.cause.score < kNearlyAsLikely;
    const bool does_the_same = linear_fit(f.A, first.A * first.cause.moved).left < 1;  // within one sigma
    if (nearly_as_likely || does_the_same) diagnosis.alternatives.push_back(f.cause);
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
