#pragma once

#include <Eigen/Core>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"
#include "core/calibration/measurement.hpp"
#include "core/evaluation/error_statistics.hpp"

namespace truepose {

enum class CalibrationMethod {
  TwoStage,      ///< the paper's: redundant columns removed by QR, the rest fitted
  LeastSquares,  ///< every column at once, the smallest correction (pseudo-inverse) among equal ones
};

struct CalibrateOptions {
  CalibrationMethod method = CalibrationMethod::TwoStage;
  int max_coarse_iterations = 200;
  int max_fine_iterations = 50;
};

enum class CalibrationFault {
  TooFewPoses,
  NotFinite,
  NotSeparable,  ///< base and reflector offset cannot be told apart
};

struct CalibrationError {
  CalibrationFault fault;
  std::string detail;  ///< one sentence for the operator
};

/// One parameter and what became of it. Names as in parameter_names().
struct IdentifiedParameter {
  std::string name;
  double nominal = 0;  ///< mm or rad; 0 for base and reflectors
  double value = 0;
  double sigma = 0;         ///< standard deviation, same unit; 0 where not identified
  bool identified = false;  ///< false: kept at nominal, because others take its place
};

/// Error statistics of one set of points through the stages.
struct StageErrors {
  int poses = 0;
  int points = 0;
  ErrorStatistics before;     ///< nominal arm, base and reflectors fitted (coarse stage)
  ErrorStatistics geometric;  ///< after the fine stage
  ErrorStatistics after;      ///< after all layers of the options
};

/// Error vectors (predicted minus measured, mm, tracker frame) of one point through the stages.
struct PointErrors {
  Eigen::Vector3d before, geometric, after;
};

struct Calibration {
  CalibrationMethod method = CalibrationMethod::TwoStage;
  bool converged = false;
  int coarse_iterations = 0;
  int fine_iterations = 0;
  CalibratedCell coarse;  ///< nominal arm with base and reflectors fitted
  CalibratedCell cell;    ///< calibrated arm
  std::vector<IdentifiedParameter> parameters;
  int rank = 0;
  double rank_gap = 0;   ///< smallest pivot kept over the largest dropped
  double condition = 0;  ///< of the kept columns, scaled to unit norm
  double sigma0_mm = 0;  ///< estimated standard deviation of one coordinate of a point of weight 1
  StageErrors identify;
  std::optional<StageErrors> validate;
  std::vector<PointErrors> points;  ///< in the order of MeasurementData::points
};

/// Fits base and reflectors alone, the arm held at `arm`: the coarse stage. Few poses suffice, so a campaign
/// aims with it.
///
/// @param points  at least five poses of varying orientation, used whatever their set
std::expected<CalibratedCell, CalibrationError> coarse_fit(const RobotModel& arm,
                                                           const MeasurementData& data);

/// Identifies base, reflectors and link errors from the points marked Identify, and judges them on those
/// marked Validate.
///
/// @param nominal  the data sheet's arm
/// @param data     points to identify: more equations than identifiable parameters (9 poses of one reflector
/// give 27) Source: method's paper, coarse stage (eqs 12 to 19) and fine stage (eqs 20 to 26).
std::expected<Calibration, CalibrationError> calibrate(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options = {});

}  // namespace truepose
