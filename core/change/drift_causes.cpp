#include "core/change/drift_causes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "core/change/drift_fit.hpp"
#include "core/fit/measured_order.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/residual_distribution.hpp"

namespace truepose {
namespace {

constexpr int kFewestLeft = 3;  // equations that have to be left to check a cause by
constexpr double kOpen = 1e4;   // width of a change that is fitted alone: as good as no prior
constexpr double kAlike = 1;    // squared distance that a cause leaves which does the same as another

/// Points, and where the reference stands to them.
struct Seen {
  const DriftReference& reference;
  std::span<const Measurement> points;
  std::shared_ptr<const DriftResiduals> at_reference;
};

std::optional<Seen> seen_by(const DriftReference& reference, std::span<const Measurement> points) {
  auto residuals = drift_residuals(reference, reference.cell, points);
  if (!residuals) return std::nullopt;
  return Seen{reference, points, std::make_shared<DriftResiduals>(*std::move(residuals))};
}

/// One change alone.
std::optional<DriftFit> fitted_alone(const PossibleChange& change, const Seen& seen) {
  DriftFit start{.cell = seen.reference.cell, .priors = {{.changes = {change}, .width = kOpen}}};
  if (change.what.kind == ChangeKind::Base)
    start.cell = with_fitted_base(start.cell, seen.points);
  else
    start.residuals = seen.at_reference;
  auto fit = fitted_drift(seen.reference, seen.points, std::move(start), Widths::Kept);
  if (!fit || !fit->posterior.left.allFinite()) return std::nullopt;
  return *std::move(fit);
}

/// Nothing where too little is left to check it by.
std::optional<DriftCause> cause_of(const DriftFit& fit, const Seen& seen) {
  const Eigen::MatrixXd N = gram(fit.priors.front().columns);
  DriftCause cause{{found_in(fit, seen.reference).front()}};
  const Eigen::VectorXd x = cause.moved.cwiseQuotient(units_of(fit.priors.front().changes.front(), fit.cell));
  const ChangeEvidence evidence(N, N * x);
  const auto equations = 3 * static_cast<int>(seen.points.size()), rank = static_cast<int>(evidence.rank());
  if (rank == 0 || equations - rank < kFewestLeft) return std::nullopt;
  cause.distance2 = fit.posterior.left.squaredNorm();
  cause.degrees = equations - rank;
  cause.evidence = evidence.best_of_fit(seen.at_reference->r.squaredNorm() - cause.distance2);
  cause.probability = ResidualDistribution(seen.reference.validation_distances2)
                          .tail(fit.posterior.left, cause.degrees, points_per_stop(seen.points));
  return cause;
}

/// The points as they would be had nothing but this cause happened.
std::vector<Measurement> points_after(const DriftCause& cause, const CalibratedCell& cell,
                                      std::span<const Measurement> points) {
  std::vector<Measurement> after(points.begin(), points.end());
  for (Measurement& point : after) point.p_WS_mm = cell.predict(point);
  if (cause.what.kind == ChangeKind::Reading)
    after[static_cast<std::size_t>(cause.what.index)].p_WS_mm += cause.moved;
  return after;
}

}  // namespace

DriftDiagnosis diagnose_drift(const DriftReference& reference, std::span<const Measurement> points) {
  struct Hypothesis {
    PossibleChange change;
    CalibratedCell cell;  ///< in which it is corrected
    DriftCause cause;
  };
  const auto seen = seen_by(reference, points);
  if (!seen) return {};
  std::vector<PossibleChange> changes = shown_changes(reference.cell, points);
  std::ranges::copy(wrong_readings(points), std::back_inserter(changes));
  std::vector<Hypothesis> all;
  for (const PossibleChange& change : changes) {
    auto fit = fitted_alone(change, *seen);
    if (!fit) continue;
    auto cause = cause_of(*fit, *seen);
    if (!cause) continue;
    cause->evidence -= std::log(static_cast<double>(std::ranges::count_if(
        changes, [&](const PossibleChange& other) { return other.what.kind == cause->what.kind; })));
    all.push_back({change, std::move(fit->cell), *std::move(cause)});
  }
  if (all.empty()) return {};
  std::ranges::stable_sort(
      all, {}, [](const Hypothesis& h) { return std::pair(!h.cause.explains(), -h.cause.evidence); });

  const Hypothesis& first = all.front();
  const std::vector<Measurement> after = points_after(first.cause, first.cell, points);
  const auto seen_after = seen_by(reference, after);
  DriftDiagnosis diagnosis;
  for (const Hypothesis& h : all) {
    diagnosis.causes.push_back(h.cause);
    if (&h == &first || !h.cause.explains()) continue;
    const auto imitation = seen_after ? fitted_alone(h.change, *seen_after) : std::nullopt;
    const bool does_the_same = imitation && imitation->posterior.left.squaredNorm() < kAlike;
    if (does_the_same || first.cause.evidence - h.cause.evidence < kPays)
      diagnosis.alternatives.push_back(h.cause);
  }
  return diagnosis;
}

}  // namespace truepose
