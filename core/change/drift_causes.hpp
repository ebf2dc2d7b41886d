#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/change/change_hypothesis.hpp"
#include "core/change/drift_reference.hpp"

namespace truepose {

/// Times the mean error at validation from which a mean error is large.
inline constexpr double kLargeFactor = 2;

/// A change fitted to the residuals, and what it leaves.
struct DriftCause : ChangeFound {
  double distance2 = 0;    ///< squared Mahalanobis distance that is left
  int degrees = 0;         ///< of freedom that are left
  double probability = 0;  ///< of so much in a cell in which nothing else changed
  bool explains() const { return probability >= kSignificance; }
};

/// What explains significant residuals.
struct DriftDiagnosis {
  std::vector<DriftCause>
      causes;  ///< those that leave something to check them by; the likeliest that explain first
  std::vector<DriftCause> alternatives;  ///< that the points do not tell from the first, where that explains

  bool explains() const { return !causes.empty() && causes.front().explains(); }
  /// Whether but one point is off, so that nothing needs to have changed.
  bool one_reading() const { return explains() && causes.front().what.kind == ChangeKind::Reading; }
};

/// Fits every cause in turn by iterated generalised least squares and compares them by their evidence: a
/// cause with more unknowns has to explain more. An alternative is less than twenty times less likely than
/// the first cause (kPays), or could do what that did to these points (joint 1's zero and a base that turns
/// about axis 1).
///
/// Source: ChangeEvidence, by Laplace's approximation where a change is large.
DriftDiagnosis diagnose_drift(const DriftReference& reference, std::span<const Measurement> points);

}  // namespace truepose
