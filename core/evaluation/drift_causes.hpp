#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"
#include "core/calibration/measurement.hpp"
#include "core/evaluation/drift_residuals.hpp"

namespace truepose {

/// Chance at which residuals are no longer taken for chance.
inline constexpr double kSignificance = 0.005;

/// What may have changed since the calibration.
enum class DriftCauseKind {
  Base,       ///< the tracker or the base moved: 6 unknowns
  Reflector,  ///< moved on the flange: 3
  JointZero,  ///< the encoder of a joint reads another angle: 1
  Reading,    ///< one point is wrong, its 3 coordinates tell nothing
};

/// A change fitted to the residuals, and what it leaves.
struct DriftCause {
  DriftCauseKind kind = DriftCauseKind::Base;
  int index = 0;          ///< of the reflector, the joint or the point, from 0
  Eigen::VectorXd moved;  ///< of the base (mm; turn about the tracker's axes, rad), the reflector (mm, flange
                          ///< frame), the joint (rad, mm) or the reading (mm, tracker frame)
  Eigen::VectorXd sigma;  ///< standard deviations of the same
  double distance2 = 0;   ///< squared Mahalanobis distance that is left
  int degrees = 0;        ///< of freedom that are left
  double probability = 0;  ///< of so much in a cell in which nothing else changed
  double score = 0;        ///< distance2 + unknowns * log(equations); the smallest is the most likely
  bool explains() const { return probability >= kSignificance; }
};

/// What explains significant residuals.
struct DriftDiagnosis {
  std::vector<DriftCause>
      causes;  ///< those that leave something to check them by; the likeliest that explain first
  std::vector<DriftCause> alternatives;  ///< that the points do not tell from the first, where that explains
};

/// Fits every cause in turn by iterated generalised least squares and compares them by the Bayesian
/// information criterion: a cause with more unknowns has to explain more. An alternative is less than twenty
/// times less likely than the first cause, or could do what that did to these points (joint 1's zero and a
/// base that turns about axis 1).
///
/// Source: Schwarz, Estimating the dimension of a model, Ann. Stat. 6 (1978).
DriftDiagnosis diagnose_drift(const DriftReference& reference, std::span<const Measurement> points);

/// "axis 3's zero moved by 0.0120 deg", "the tracker or the base moved by 0.21 mm and 0.0030 deg".
std::string described(const DriftCause& cause, const CalibratedCell& cell,
                      std::span<const Measurement> points);
/// What to do about it, as an order: "fit the frame again".
std::string remedy(const DriftCause& cause);

}  // namespace truepose
