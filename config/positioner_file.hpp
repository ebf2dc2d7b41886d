#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>

#include "config/model_file.hpp"
#include "core/frames/frame_readings.hpp"

namespace truepose::config {

/// A positioner, and the workpiece on it: all that it takes to send the arm's TCP to the workpiece. As a
/// tool's file it keeps the readings of the workpiece, and the table that they are converted by.
struct PositionerFile {
  int number = 2;                                          ///< of MACHINE_DEF
  std::string arm;                                         ///< name of the nominal robot
  std::string model;                                       ///< when the arm's model was made, RFC 3339
  Eigen::Isometry3d X_BR = Eigen::Isometry3d::Identity();  ///< value of ROOT for the controller
  ModelFile table;          ///< calibrated from the station of the tracker that the arm's base is seen from
  FrameReadings workpiece;  ///< of points on the table, q its joints
};

/// In it the table's model stands as the text that it is as a file.
std::string positioner_yaml(const PositionerFile& positioner);
/// Refuses one of another arm, or that was measured under another model of it. Throws ConfigError.
PositionerFile load_positioner(const std::filesystem::path& file, const ModelFile& model);

}  // namespace truepose::config
