#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/text_file.hpp"
#include "core/identify/calibrate.hpp"
#include "core/judge/drift_causes.hpp"

namespace truepose::config {

/// A calibrated arm as it is kept in a model file: what compensation needs, and where it came from.
struct ModelFile {
  std::string name;     ///< of the nominal robot
  std::string serial;   ///< of the arm it was identified on, or empty
  std::string created;  ///< RFC 3339
  CalibratedCell cell;  ///< values in mm and rad; joints carry limits and signs of the nominal arm
  std::vector<IdentifiedParameter> parameters;
  double validation_mean_mm = 0;  ///< after all layers, on validation poses; 0 = nothing was validated
  /// Of the parameters, as Calibration::covariance, and of a point about what they predict: what a drift
  /// check judges by. Empty in files of before.
  Eigen::MatrixXd covariance;
  std::optional<MeasurementNoise> noise;
};

/// What a drift check judges by.
///
/// @param stated  noise in place of that in the file
/// @return nothing where neither file nor caller tells the noise and nothing was validated
std::optional<DriftReference> drift_reference(const ModelFile& model,
                                              const std::optional<MeasurementNoise>& stated = {});

/// Text of a model file (YAML; mm, rad and kg, every number with the digits that bring it back exactly).
std::string model_yaml(const ModelFile& model);
/// Reads such a text; `file_name` stands in the messages. Throws ConfigError.
ModelFile parse_model(const std::string& text, const std::string& file_name);
ModelFile load_model(const std::filesystem::path& file);

}  // namespace truepose::config
