#include "core/judge/drift_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/judge/error_law.hpp"

namespace truepose {
namespace {

/// Fewer points are said to be too few to tell the causes apart.
constexpr std::size_t kEnoughPoints = 4;

std::string mm(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f mm", value);
  return text;
}

/// The mean error that an unchanged cell would show.
double expected_mean_mm(const Eigen::MatrixXd& S) {
  double sum = 0;
  for (Eigen::Index row = 0; row < S.rows(); row += 3) sum += std::sqrt(S.diagonal().segment<3>(row).sum());
  return kMeanOverRms * sum / static_cast<double>(S.rows() / 3);
}

/// "axis 1's zero moved by 0.0100 deg, or the tracker .. moved by ..: the points do not tell these apart"
std::string likely_cause(const DriftCheck& check, const CalibratedCell& cell,
                         std::span<const Measurement> points) {
  const bool few = points.size() < kEnoughPoints;
  const std::string too_few = std::to_string(points.size()) +
                              (points.size() == 1 ? " point is" : " points are") +
                              " too few to tell why: measure at least 5";
  if (check.causes.empty() || !check.causes.front().explains()) {
    if (few) return too_few;
    return "no moved tracker, base or reflector, joint zero or single reading explains it: the arm itself "
           "has changed, calibrate again";
  }
  const DriftCause& first = check.causes.front();
  std::string text = "most likely " + described(first, cell, points);
  for (const DriftCause& other : check.alternatives) text += ", or " + described(other, cell, points);
  if (!check.alternatives.empty()) text += " (these points do not tell them apart)";
  return few ? text + ", but " + too_few : text + ": " + remedy(first);
}

std::string reason_of(const DriftCheck& check, bool significant, bool large, bool unknown,
                      const DriftReference& reference, std::span<const Measurement> points) {
  const std::string against = mm(check.mean_mm) + " on average, against " + mm(check.reference_mm) +
                              (reference.validation_mean_mm > 0 ? " at validation" : " expected");
  if (!significant && !unknown) return "the points agree with the model: off by " + against;
  if (unknown)
    return "the points are off by " + against +
           ", but the model is not known well enough at these poses to call that a change: measure others";
  return "the points are off by " + against + (large ? "" : ", more than by chance but harmless") + "; " +
         likely_cause(check, reference.cell, points);
}

}  // namespace

std::expected<DriftCheck, std::string> drift_check(const DriftReference& reference,
                                                   std::span<const Measurement> points) {
  const auto residuals = drift_residuals(reference, reference.cell, points);
  if (!residuals) return std::unexpected(residuals.error());

  DriftCheck check;
  for (const Measurement& point : points) {
    const Eigen::Vector3d error = reference.cell.predict(point) - point.p_WS_mm;
    check.errors_mm.push_back(error);
    check.mean_mm += error.norm() / static_cast<double>(points.size());
    check.max_mm = std::max(check.max_mm, error.norm());
  }
  check.reference_mm =
      reference.validation_mean_mm > 0 ? reference.validation_mean_mm : expected_mean_mm(residuals->S);
  check.distance2 = residuals->r.squaredNorm();
  check.degrees = static_cast<int>(residuals->r.size());
  check.probability = ErrorLaw(reference.validation_distances2).tail(residuals->r, check.degrees);

  const bool significant = check.probability < kSignificance;
  const bool large = check.mean_mm > kLargeFactor * check.reference_mm;
  const bool unknown =
      !significant && large && expected_mean_mm(residuals->S) > kLargeFactor * check.reference_mm;
  if (significant) {
    DriftDiagnosis diagnosis = diagnose_drift(reference, points);
    check.causes = std::move(diagnosis.causes);
    check.alternatives = std::move(diagnosis.alternatives);
  }
  const bool one_reading = !check.causes.empty() && check.causes.front().explains() &&
                           check.causes.front().kind == DriftCauseKind::Reading;
  if (significant && large && !one_reading)
    check.verdict = DriftVerdict::Failed;
  else if (significant || unknown)
    check.verdict = DriftVerdict::Warning;
  check.reason = reason_of(check, significant, large, unknown, reference, points);
  return check;
}

}  // namespace truepose
