#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/calibrate/calibrate_options.hpp"
#include "core/calibrate/calibration.hpp"

namespace truepose {

/// An identification without a residual field, which could take warmth for something of the poses.
struct ThermalBasis {
  CalibratedCell cell;
  Eigen::MatrixXd covariance;  ///< of its parameters
  double sigma0_mm = 0;
  std::vector<RejectedPoint> rejected;  ///< points that take no part
};

/// The arm's answer to warmth, identified in turn with everything else: points are brought to the reference
/// temperatures by it and identified from as if the arm had stood there; then it is fitted to what that
/// leaves, together with all parameters. The two meet within noise after two rounds, as both are nearly
/// linear. The covariance is that of both together.
struct ThermalStage {
  bool pays = false;         ///< points are predicted better with it, beyond chance, each by the others
  MeasurementData data;      ///< all points, with their warmth as temperatures
  ThermalResponse response;  ///< as known so far
  std::optional<WarmUpClock> clock;
  Eigen::MatrixXd inflation;  ///< to be added to the parameters' covariance for what the response leaves open
  double without_rms_mm = 0, rms_mm = 0;  ///< as ThermalChoice
};

/// Seeks it in what a first identification leaves.
///
/// Under ThermalUse::Auto warmth by time or order is kept only where it pays beyond doubt, where it is not
/// the joints themselves that it follows, and where no base that moved in the same way explains the points as
/// well.
///
/// @param basis  identified from `data` as it is
/// @return nothing where no point shows warmth
std::optional<ThermalStage> thermal_stage(const ThermalBasis& basis, const MeasurementData& data,
                                          const CalibrateOptions& options);

/// The points as an arm at the reference would have shown them.
MeasurementData at_reference(const ThermalStage& stage, const ThermalBasis& basis);

/// Fits the response again to what an identification at the reference leaves.
///
/// @param basis  identified from `there`
/// @param there  at_reference()
void refine(ThermalStage& stage, const ThermalBasis& basis, const MeasurementData& there,
            const CalibrateOptions& options);

/// Adds the choice to a calibration at the reference, and what the response leaves open to what is known of
/// the parameters.
void add_thermal_choice(const ThermalStage& stage, Calibration& made);

}  // namespace truepose
