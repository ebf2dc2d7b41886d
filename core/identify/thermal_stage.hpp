#pragma once

#include <expected>
#include <functional>

#include "core/identify/calibrate.hpp"

namespace truepose {

/// What the arm's answer to warmth is sought beside: an identification without a residual field, which could
/// take warmth for something of the poses.
struct ThermalBasis {
  CalibratedCell cell;
  Eigen::MatrixXd covariance;  ///< of its parameters
  double sigma0_mm = 0;
  std::vector<RejectedPoint> rejected;  ///< points that take no part
};

/// What became of it.
struct ThermalStage {
  ThermalChoice choice;
  Eigen::MatrixXd inflation;  ///< to be added to the parameters' covariance, as the response is not known
                              ///< exactly; empty where none was kept
};

/// Whether points are screened by what they say at the reference, or those are left out that were before.
enum class Screening { Anew, Kept };

/// Identifies the parameters from points at the reference.
using IdentifyAtReference =
    std::function<std::expected<ThermalBasis, CalibrationError>(const MeasurementData&, Screening)>;

/// Identifies how the arm answers to warmth, together with all that `identify` does, where that pays.
///
/// Points are brought to the reference temperatures by the response and identified from as if the arm had
/// stood there; the response is fitted to what that leaves, beside all parameters, and so on in turn: the two
/// meet within noise after two rounds, as both are nearly linear. Points are screened anew in the last, which
/// alone knows warmth well enough to tell it from a gross error. The covariance is that of both together.
/// Whether it pays is asked of each point as the others predict it.
///
/// Under ThermalUse::Auto warmth by time or order is kept only where it pays beyond doubt, where it is not
/// the joints themselves that it follows, and where no base that moved in the same way explains the points as
/// well.
///
/// @param basis     identified from `data` as it is
/// @return nothing where no point tells warmth
/// Errors: those of `identify`.
std::expected<std::optional<ThermalStage>, CalibrationError> with_thermal_response(
    ThermalBasis basis, const MeasurementData& data, const CalibrateOptions& options,
    const IdentifyAtReference& identify);

/// Adds what the response leaves open to what is known of the parameters.
void inflate(Calibration& made, const Eigen::MatrixXd& inflation);

}  // namespace truepose
