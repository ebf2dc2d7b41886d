#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/field/field_choice.hpp"
#include "core/fit/deviation_selection.hpp"
#include "core/fit/identifiability.hpp"
#include "core/fit/least_squares_solver.hpp"
#include "core/fit/null_space.hpp"
#include "core/fit/prior.hpp"
#include "core/fit/target_turns.hpp"
#include "core/fit/thermal_response.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/fit/warm_up.hpp"
#include "core/math/statistics.hpp"

namespace truepose {

/// One parameter and what became of it. Names as in parameter_names().
struct IdentifiedParameter {
  std::string name;
  double nominal = 0;  ///< mm or rad; 0 for base and reflectors
  double value = 0;
  double sigma = 0;         ///< standard deviation, same unit; 0 where not identified
  bool identified = false;  ///< false: kept at nominal, because others take its place
  double data_share = 0;    ///< 1: known from the data alone; less: the prior says the rest
};

/// How far 6-D targets are turned from where a cell has them, rad.
struct TurnStatistics {
  double mean_rad = 0, rms_rad = 0, max_rad = 0;
};

/// The same of one set of points, under the nominal arm and under the calibrated one.
struct TurnErrors {
  int readings = 0;
  TurnStatistics before, after;
};

/// Error statistics of one set of points through the stages.
struct StageErrors {
  int poses = 0;
  int points = 0;
  ErrorStatistics before;     ///< nominal arm, base and reflectors fitted (coarse stage)
  ErrorStatistics geometric;  ///< after the fine stage
  ErrorStatistics after;  ///< after all layers of the options; points that a residual field was fitted to as
                          ///< one predicts them that did not see their pose
  std::optional<TurnErrors> orientation_errors;  ///< where targets have orientations
};

/// Error vectors (predicted minus measured, mm, tracker frame of the first station) of one point through the
/// stages, as in StageErrors.
struct PointErrors {
  Eigen::Vector3d before, geometric, after;
};

/// A point that the others contradict.
struct RejectedPoint {
  std::size_t point = 0;   ///< index into MeasurementData::points
  double residual_mm = 0;  ///< length of its error under the model that judged it, residual field left out
  double sigmas = 0;       ///< the same, whitened, in standard deviations of one coordinate
  double turn_rad = 0;     ///< by which its target is turned off, where that is what contradicts the others
};

/// How well what was measured from one of several stations is predicted.
struct StationErrors {
  StageErrors identify;
  std::optional<StageErrors> validate;
};

/// Whether the arm's answer to warmth was kept.
struct ThermalChoice {
  std::optional<ThermalResponse> response;  ///< none: the arm as if it were always as warm predicts as well
  /// Clock of the warm-up model; the reference is then the warm arm. None: temperatures were measured.
  std::optional<WarmUpClock> clock;
  double without_rms_mm = 0;  ///< error of points as the others predict them, whitened, without the response
  double rms_mm = 0;          ///< and with it
};

struct Calibration {
  bool converged = false;
  int coarse_iterations = 0;
  int fine_iterations = 0;
  StepSolver fine_solver = StepSolver::Orthogonal;
  std::vector<double> coarse_rms_mm, fine_rms_mm;  ///< before each iteration, per point, whitened
  CalibratedCell coarse;                           ///< nominal arm with base and reflectors fitted
  CalibratedCell geometric;                        ///< after the fine stage
  CalibratedCell cell;                             ///< calibrated arm with all layers
  std::vector<IdentifiedParameter> parameters;
  Eigen::MatrixXd covariance;  ///< of the parameters, order of ParameterLayout, the base's rotation as a turn
  int rank = 0;
  double rank_gap = 0;                 ///< smallest pivot kept over the largest dropped
  ObservabilityIndices observability;  ///< of the same
  std::vector<Combination> unknown;    ///< what no pose shows, in words
  std::vector<Combination> weak;       ///< what the data say less about than the data sheet
  double sigma0_mm = 0;  ///< estimated standard deviation of one coordinate of a point of weight 1
  bool prior_used = false;
  PriorScale prior_scale;               ///< as used
  std::vector<RejectedPoint> rejected;  ///< points to identify that the loss took out
  std::vector<RejectedPoint>
      validation_outliers;  ///< beyond six sigma too, but in the statistics all the same
  std::optional<DeviationChoice> non_geometric;
  std::optional<FieldChoice> field;
  std::optional<ThermalChoice> thermal;  ///< where points tell warmth; all else is of the reference
  TransferUncertainty transfer;          ///< over the joint limits
  double misfit_mm = 0;  ///< of a coordinate: what the model leaves beyond the stated noise and chance
  StageErrors identify;
  std::optional<StageErrors> validate;
  std::vector<StationErrors> stations;             ///< where there are several
  std::vector<std::optional<Mounting>> mountings;  ///< of each reflector that is a 6-D target
  std::vector<PointErrors> points;                 ///< in the order of MeasurementData::points

  /// How well a predicted reflector position is known: mm^2, tracker frame.
  Eigen::Matrix3d position_covariance(const JointVector& q, int smr, Approach approach = {}) const {
    return truepose::position_covariance(cell, covariance, q, smr, approach) +
           misfit_mm * misfit_mm * Eigen::Matrix3d::Identity();
  }
};

/// Drops the further stations' bases from cell, parameters and covariance: a model of the arm has one base,
/// the one that the first station sees.
void keep_first_station(Calibration& calibration);

}  // namespace truepose
