#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/text_file.hpp"
#include "core/calibrate/calibration.hpp"
#include "core/change/drift_causes.hpp"
#include "core/quality/calibration_verdict.hpp"

namespace truepose::config {

/// A point that a model was validated on.
struct ValidationPoint {
  JointVector q;  ///< rad, mm
  int smr = 0;    ///< index of the reflector
  std::vector<std::int8_t> direction;
  std::optional<LinkMass> payload;
  Eigen::Vector3d p_WS_mm{0, 0, 0};

  Measurement measurement() const;
};

/// A calibrated arm as it is kept in a model file: what compensation needs, and where it came from.
struct ModelFile {
  std::string name;     ///< of the nominal robot
  std::string serial;   ///< of the arm it was identified on, or empty
  std::string created;  ///< RFC 3339
  CalibratedCell cell;  ///< values in mm and rad; joints carry limits and signs of the nominal arm
  std::vector<IdentifiedParameter> parameters;
  double validation_mean_mm = 0;  ///< after all layers, on validation poses; 0 = nothing was validated
  /// Of the parameters, as Calibration::covariance, and of a point about what they predict: what a drift
  /// check judges by.
  Eigen::MatrixXd covariance;
  std::optional<MeasurementNoise> noise;
  double misfit_mm = 0;                       ///< as Calibration's
  std::vector<double> validation_distances2;  ///< as DriftReference's
  std::optional<ThermalResponse> thermal;     ///< where warmth was identified; all else is of its reference
  std::string updates;  ///< the model that this one brings up to date, by id or file; empty: none
  /// Measured under several payloads, of which the robot file calls none the arm's own.
  bool several_payloads = false;
  std::optional<CalibrationVerdict> verdict;  ///< on it when it was made
  std::string station;  ///< in whose tracker's frame the base is; empty where there was one station
  /// Its own proof: what it was validated on, and the largest correction of a joint there. Empty and 0
  /// where each validation point was predicted by another fit.
  std::vector<ValidationPoint> validation;
  double largest_correction_deg = 0;
  std::string sha256;  ///< of the text before it, as it was read
};

/// Every number of a model comes back from its text exactly, so that only the rounding of another compiler is
/// to be allowed for.
inline constexpr double kReproduced_mm = 1e-3;
inline constexpr double kReproduced_deg = 1e-3;

/// Whether the arm bends under its payload, and the payload is not stated.
bool is_payload_open(const ModelFile& model);

/// The points of a calibration that it was validated on.
std::vector<ValidationPoint> validation_points(const MeasurementData& data);
/// The joints at these points.
std::vector<JointVector> poses_of(std::span<const ValidationPoint> points);

/// @name Why a model is not the one that was made, or nothing
/// @{
/// It misses its own validation points by another mean than it says.
std::optional<std::string> other_error(const CalibratedCell& cell, std::span<const ValidationPoint> points,
                                       double made_mm);
/// It corrects a joint at the poses by more than it says; where that is 0 nothing is known.
std::optional<std::string> larger_correction(const RobotModel& nominal, const CalibratedCell& cell,
                                             std::span<const JointVector> poses, double made_deg);
/// It was identified from another arm than `nominal`: what it keeps of that, parameter by parameter.
std::optional<std::string> other_nominal(const RobotModel& nominal, const ModelFile& model);
/// @}

/// What a drift check judges by.
///
/// @param stated  noise in place of that in the file
/// @return nothing where neither file nor caller tells the noise and nothing was validated
std::optional<DriftReference> drift_reference(const ModelFile& model,
                                              const std::optional<MeasurementNoise>& stated = {});

/// Text of a model file (YAML; mm, rad and kg, every number with the digits that bring it back exactly),
/// whose last line is the hash of the others.
std::string model_yaml(const ModelFile& model);
/// Reads such a text; `file_name` stands in the messages. Throws ConfigError, also where the hash is
/// another's.
ModelFile parse_model(const std::string& text, const std::string& file_name);
/// The same, and throws where the model does not reproduce its own validation error.
ModelFile parse_checked_model(const std::string& text, const std::string& file_name);
/// The same of a file.
ModelFile load_model(const std::filesystem::path& file);

}  // namespace truepose::config
