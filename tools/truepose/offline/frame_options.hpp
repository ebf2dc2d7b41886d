#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "config/frame_file.hpp"
#include "config/model_file.hpp"
#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// A tool of a command: given by its numbers, or by a file of `truepose tool`.
struct Tool {
  int number = 0;                                                  ///< of TOOL_DATA; 0: given by its numbers
  Eigen::Isometry3d X_controller = Eigen::Isometry3d::Identity();  ///< what the controller has
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< where it is on the calibrated arm's flange
  std::optional<MeasuredFrame> measured;
};

/// A base likewise.
struct Base {
  int number = 0;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  std::optional<PoseCovariance> covariance;
};

/// What stands between the commas of an option that takes either.
using FrameWords = std::vector<std::string>;
inline constexpr const char* kFrameType = "FILE|X,Y,Z,A,B,C";

/// @param option  in messages
/// Throws ConfigError. Nothing where nothing was given.
std::optional<Tool> tool_of(const FrameWords& words, const std::string& option, const RobotModel& nominal,
                            const config::ModelFile& model);
std::optional<Base> base_of(const FrameWords& words, const std::string& option,
                            const config::ModelFile& model);

/// Refuses a model that tells no noise where `stated` tells none either. Throws ConfigError.
MeasuringCell measuring_cell_of(const config::ModelFile& model, const std::filesystem::path& file,
                                const std::optional<MeasurementNoise>& stated = {});

}  // namespace truepose::tools
