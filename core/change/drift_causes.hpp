#pragma once

#include <Eigen/Core>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "core/change/cell_change.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// A calibrated cell and how far its predictions can be trusted.
struct DriftReference {
  CalibratedCell cell;
  /// Of the parameters, as Calibration::covariance; empty: taken as exact, all scatter is in the noise.
  Eigen::MatrixXd covariance;
  MeasurementNoise noise;         ///< of a measured point about what exact parameters would predict
  double validation_mean_mm = 0;  ///< mean error on validation poses; 0 = nothing was validated
  /// point_distances2() of the validation points: how the model's errors really scatter. Empty: as normal
  /// errors would, all about the model is taken as it says of itself.
  std::vector<double> validation_distances2;
};

/// The stacked residuals of some points and what they depend on, made alike: multiplied by the inverse of L,
/// where L L' = S = J C J' + N, the covariance C of the parameters and the noise N of each point.
struct DriftResiduals {
  Eigen::VectorXd r;        ///< measured minus predicted, whitened
  Eigen::MatrixXd J;        ///< derivative of the predictions to the parameters, whitened (ParameterLayout)
  Eigen::MatrixXd inverse;  ///< of L
  Eigen::MatrixXd S;        ///< mm^2
};

/// @param cell  that of the reference, or that with something moved
/// Errors: no point, a number that is not finite, an S that is not positive definite.
std::expected<DriftResiduals, std::string> drift_residuals(const DriftReference& reference,
                                                           const CalibratedCell& cell,
                                                           std::span<const Measurement> points);

/// Squared length of r of each point, regarded alone.
///
/// Errors: as drift_residuals().
std::expected<std::vector<double>, std::string> point_distances2(const DriftReference& reference,
                                                                 std::span<const Measurement> points);

/// Chance at which residuals are no longer taken for chance.
inline constexpr double kSignificance = 0.005;
/// Times the mean error at validation from which a mean error is large.
inline constexpr double kLargeFactor = 2;

/// A change fitted to the residuals, and what it leaves.
struct DriftCause {
  Change what;
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

  bool explains() const { return !causes.empty() && causes.front().explains(); }
  /// Whether but one point is off, so that nothing needs to have changed.
  bool one_reading() const { return explains() && causes.front().what.kind == ChangeKind::Reading; }
};

/// Fits every cause in turn by iterated generalised least squares and compares them by the Bayesian
/// information criterion: a cause with more unknowns has to explain more. An alternative is less than twenty
/// times less likely than the first cause, or could do what that did to these points (joint 1's zero and a
/// base that turns about axis 1).
///
/// Source: Schwarz, Estimating the dimension of a model, Ann. Stat. 6 (1978).
DriftDiagnosis diagnose_drift(const DriftReference& reference, std::span<const Measurement> points);

std::string described(const DriftCause& cause, const CalibratedCell& cell,
                      std::span<const Measurement> points);
/// What to do about it, as an order: "fit the frame again".
std::string remedy(const DriftCause& cause);

}  // namespace truepose
