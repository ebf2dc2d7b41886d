#include "core/change/drift_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/diagnosis/mistaken_points.hpp"
#include "core/fit/measured_order.hpp"
#include "core/formatted.hpp"
#include "core/math/residual_distribution.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

/// Fewer points are said to be too few to tell the causes apart.
constexpr std::size_t kEnoughPoints = 4;
/// With more, several changes at once take minutes to find.
constexpr std::size_t kMostForSeveral = 60;

std::string mm(double value) { return formatted("%.3f mm", value); }

/// The mean error that an unchanged cell would show.
double expected_mean_mm(const Eigen::MatrixXd& S) {
  double sum = 0;
  for (Eigen::Index row = 0; row < S.rows(); row += 3) sum += std::sqrt(S.diagonal().segment<3>(row).sum());
  return kMeanOverRms * sum / static_cast<double>(S.rows() / 3);
}

/// Several changes at once, wrong columns or units, or the arm itself.
std::string no_single_cause(const DriftReference& reference, std::span<const Measurement> points) {
  if (const auto mistake = mistaken_points(reference.cell, points)) return *mistake;
  if (points.size() > kMostForSeveral)
    return "no moved tracker, base or reflector, joint zero or single reading alone explains it: check by "
           "fewer points, or calibrate again";
  const auto update = update_after_drift(reference, points);
  if (!update || !update->explains)
    return "no moved tracker, base or reflector, joint zero, thermal drift or wrong reading explains it, alone or "
           "together: the arm itself has changed, calibrate again";
  std::string text = "no change alone explains it, these together do: ";
  for (const auto* moves : {&update->moves, &update->wrong})
    for (const ChangeFound& move : *moves)
      text += (text.ends_with(": ") ? "" : "; ") + described_with_sigma(move, reference.cell, points);
  return text;
}

/// "axis 1's zero moved by 0.0100 deg, or the tracker .. moved by ..: the points do not tell these apart"
std::string likely_cause(const DriftCheck& check, const DriftReference& reference,
                         std::span<const Measurement> points) {
  const CalibratedCell& cell = reference.cell;
  const bool few = points.size() < kEnoughPoints;
  const std::string too_few = std::to_string(points.size()) +
                              (points.size() == 1 ? " point is" : " points are") +
                              " too few to find the cause: measure at least " + std::to_string(kEnoughPoints);
  if (!check.explains()) return few ? too_few : no_single_cause(reference, points);
  const DriftCause& first = check.causes.front();
  std::string text = "most likely " + described(first, cell, points);
  for (const DriftCause& other : check.alternatives) text += ", or " + described(other, cell, points);
  if (!check.alternatives.empty()) text += " (these points do not separate them)";
  return few ? text + ", but " + too_few : text.append(": ").append(remedy(first.what.kind));
}

std::string reason_of(const DriftCheck& check, const DriftReference& reference,
                      std::span<const Measurement> points) {
  const std::string against = mm(check.mean_mm) + " on average, against " + mm(check.reference_mm) +
                              (reference.validation_mean_mm > 0 ? " at validation" : " expected");
  if (check.unknown())
    return "the points are off by " + against +
           ", but the model is not known well enough at these poses to call that a change: measure others";
  if (!check.significant()) return "the points agree with the model: off by " + against;
  return "the points are off by " + against + (check.large() ? "" : ", a significant but harmless amount") +
         "; " + likely_cause(check, reference, points);
}

DriftVerdict verdict_of(const DriftCheck& check) {
  if (check.significant() && check.large() && !check.one_reading()) return DriftVerdict::Failed;
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
  signs.probability = ResidualDistribution(reference.validation_distances2)
                          .tail(residuals->r, signs.degrees, points_per_stop(points));
  return signs;
}

std::expected<DriftCheck, std::string> drift_check(const DriftReference& reference,
                                                   std::span<const Measurement> points) {
  auto signs = drift_signs(reference, points);
  if (!signs) return std::unexpected(signs.error());
  DriftCheck check{{*std::move(signs)}, {}};
  if (check.significant()) static_cast<DriftDiagnosis&>(check) = diagnose_drift(reference, points);
  check.verdict = verdict_of(check);
  check.reason = reason_of(check, reference, points);
  return check;
}

}  // namespace truepose
