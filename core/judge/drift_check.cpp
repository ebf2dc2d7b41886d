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

std::string reason_of(const DriftCheck& check, const DriftReference& reference,
                      std::span<const Measurement> points) {
  const std::string against = mm(check.mean_mm) + " on average, against " + mm(check.reference_mm) +
                              (reference.validation_mean_mm > 0 ? " at validation" : " expected");
  if (check.unknown())
    return "the points are off by " + against +
           ", but the model is not known well enough at these poses to call that a change: measure others";
  if (!check.significant()) return "the points agree with the model: off by " + against;
  return "the points are off by " + against + (check.large() ? "" : ", more than by chance but harmless") +
         "; " + likely_cause(check, reference.cell, points);
}

DriftVerdict verdict_of(const DriftCheck& check) {
  const bool one_reading = !check.causes.empty() && check.causes.front().explains() &&
                           check.causes.front().what.kind == ChangeKind::Reading;
  if (check.significant() && check.large() && !one_reading) return DriftVerdict::Failed;
  return check.significant() || check.unknown() ? DriftVerdict::Warning : DriftVerdict::Ok;
}

}  // namespace

std::expected<DriftSigns, std::string> drift_signs(const DriftReference& reference,
                                                   std::span<const Measurement> points) {
  const auto residuals = drift_residuals(reference, reference.cell, points);
  if (!residuals) return std::unexpected(residuals.error());

  DriftSigns signs;
  for (const Measurement& point : points) {
    const Eigen::Vector3d error = reference.cell.predict(point) - point.p_WS_mm;
    signs.errors_mm.push_back(error);
    signs.mean_mm += error.norm() / static_cast<double>(points.size());
    signs.max_mm = std::max(signs.max_mm, error.norm());
  }
  signs.expected_mm = expected_mean_mm(residuals->S);
  signs.reference_mm = reference.validation_mean_mm > 0 ? reference.validation_mean_mm : signs.expected_mm;
  signs.distance2 = residuals->r.squaredNorm();
  signs.degrees = static_cast<int>(residuals->r.size());
  signs.probability = ErrorLaw(reference.validation_distances2).tail(residuals->r, signs.degrees);
  return signs;
}

std::expected<DriftCheck, std::string> drift_check(const DriftReference& reference,
                                                   std::span<const Measurement> points) {
  auto signs = drift_signs(reference, points);
  if (!signs) return std::unexpected(signs.error());
  DriftCheck check{*std::move(signs)};
  if (check.significant()) {
    DriftDiagnosis diagnosis = diagnose_drift(reference, points);
    check.causes = std::move(diagnosis.causes);
    check.alternatives = std::move(diagnosis.alternatives);
  }
  check.verdict = verdict_of(check);
  check.reason = reason_of(check, reference, points);
  return check;
}

}  // namespace truepose
