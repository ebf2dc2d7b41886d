#pragma once

#include <Eigen/Core>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/measurement.hpp"
#include "core/judge/drift_causes.hpp"

namespace truepose {

/// Ok, Warning or Failed by two questions, each answered once for all points:
/// - significant: would an unchanged cell give residuals so large less often than kSignificance (ErrorLaw)?
/// - large: is the mean error more than kLargeFactor times what it was on validation poses (where nothing was
///   validated: than what the model expects)?
///
/// Both: Failed, unless a single reading explains it all, which is to be measured again: Warning. Significant
/// alone: Warning, a change that does no harm. Else Ok, but for large errors where the model expects such
/// ones of itself, so that they do not exclude a change: Warning.
enum class DriftVerdict { Ok, Warning, Failed };

inline constexpr double kLargeFactor = 2;

struct DriftCheck {
  DriftVerdict verdict = DriftVerdict::Ok;
  std::string reason;  ///< one or two sentences for the operator
  double mean_mm = 0;
  double max_mm = 0;
  double reference_mm = 0;                 ///< what the mean is judged by
  double distance2 = 0;                    ///< squared Mahalanobis distance of all residuals
  int degrees = 0;                         ///< of freedom: coordinates measured
  double probability = 0;                  ///< that an unchanged cell gives as much
  std::vector<Eigen::Vector3d> errors_mm;  ///< predicted minus measured, tracker frame
  /// Where the residuals are significant: every change that the points can tell, the most likely first.
  std::vector<DriftCause> causes;
  std::vector<DriftCause> alternatives;  ///< explain the points about as well as the first of `causes`
};

/// Whether a calibrated cell is still right, from a handful of points of known joints.
///
/// The squared Mahalanobis distance of the residuals under drift_residuals()' S is chi-square distributed
/// where nothing has changed and the model is perfect; how real ones scatter, the validation says. Where it
/// is significant, diagnose_drift() looks for the cause.
///
/// @param points  at least one; reflectors by index of the cell's
/// Errors: no point, a number that is not finite, a noise of zero.
/// Source: Mahalanobis, On the generalised distance in statistics, Proc. Nat. Inst. Sci. India 2 (1936).
std::expected<DriftCheck, std::string> drift_check(const DriftReference& reference,
                                                   std::span<const Measurement> points);

}  // namespace truepose
