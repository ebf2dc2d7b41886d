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

enum class CalibrationMethod { TwoStage, LeastSquares };

struct CalibrateOptions {
  CalibrationMethod method = CalibrationMethod::TwoStage;
  int max_coarse_iterations = 200;
  int max_fine_iterations = 50;
};

enum class CalibrationFault {
  TooFewPoses,
  NotFinite,
  ConstantOrientation,  ///< base and reflector offset cannot be told apart
  RankDeficient,
};

struct CalibrationError {
  CalibrationFault fault;
  std::string detail;  ///< one sentence for the operator
};

/// One identified parameter. Names: "base.x".."base.rz", "smr.NAME.x", "link2.a", .alpha, .d, .theta, .beta.
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
  int point = 0;  ///< index into MeasurementData::points
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
  double condition = 0;   ///< of the kept columns, scaled to unit norm
  double sigma0_mm = 0;   ///< estimated standard deviation of one coordinate
  StageErrors identify;
  std::optional<StageErrors> validate;
  std::vector<PointErrors> points;  ///< in the order of MeasurementData::points
};

/// Identifies base, reflectors and link errors from the points marked Identify, and judges them on those marked Validate.
///
/// @param nominal  the data sheet's arm
/// @param data     at least 5 distinct poses to identify
/// Source: method's paper, stages 1 (eqs 12 to 19) and 2 (eqs 20 to 26).
std::expected<Calibration, CalibrationError> calibrate(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options = {});

}  // namespace truepose
