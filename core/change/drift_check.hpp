#pragma once

#include <Eigen/Core>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "core/change/drift_causes.hpp"
#include "core/change/drift_update.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Two questions, each answered once for all points.
struct DriftSigns {
  double mean_mm = 0;
  double max_mm = 0;
  double reference_mm = 0;                 ///< what the mean is judged by
  double expected_mm = 0;                  ///< mean error that the model expects of itself at these points
  double distance2 = 0;                    ///< squared Mahalanobis distance of all residuals
  int degrees = 0;                         ///< of freedom: coordinates measured
  double probability = 0;                  ///< that an unchanged cell gives as much
  std::vector<Eigen::Vector3d> errors_mm;  ///< predicted minus measured, tracker frame

  /// Whether an unchanged cell gives residuals so large less often than kSignificance (ResidualDistribution).
  bool significant() const { return probability < kSignificance; }
  /// Whether the mean error is more than kLargeFactor times what it was on validation poses (where nothing
  /// was validated: than what the model expects).
  bool large() const { return mean_mm > kLargeFactor * reference_mm; }
  /// Whether the points are far off by chance alone: the model expects as much of itself, so that they do not
  /// exclude a change.
  bool unknown() const { return !significant() && large() && expected_mm > kLargeFactor * reference_mm; }
};

/// Significant and large: Failed, unless a single reading explains it all, which is to be measured again:
/// Warning. Significant alone: Warning, a change that does no harm. Unknown: Warning. Else Ok.
enum class DriftVerdict { Ok, Warning, Failed };

struct DriftCheck : DriftSigns, DriftDiagnosis {
  DriftVerdict verdict = DriftVerdict::Ok;
  std::string reason;  ///< one or two sentences for the operator
};

/// The questions of drift_check(), without looking for the cause, which takes long with many points.
///
/// Errors: as drift_check().
std::expected<DriftSigns, std::string> drift_signs(const DriftReference& reference,
                                                   std::span<const Measurement> points);

/// Whether a calibrated cell is still right, from a handful of points of known joints.
///
/// The squared Mahalanobis distance of the residuals under drift_residuals()' S is chi-square distributed
/// where nothing has changed and the model is perfect; how real ones scatter, the validation says. Where it
/// is significant, diagnose_drift() looks for the cause; where no single one explains the points,
/// update_after_drift() for several at once, and mistaken_points() for what may be wrong with all of them.
///
/// @param points  at least one; reflectors by index of the cell's
/// Errors: no point, a number that is not finite, a noise of zero.
/// Source: Mahalanobis, On the generalised distance in statistics, Proc. Nat. Inst. Sci. India 2 (1936).
std::expected<DriftCheck, std::string> drift_check(const DriftReference& reference,
                                                   std::span<const Measurement> points);

}  // namespace truepose
