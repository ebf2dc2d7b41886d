#pragma once

#include <Eigen/Geometry>
#include <expected>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "core/frames/tool_frame.hpp"

namespace truepose::config {

struct ModelFile;
struct TableReading;

/// A tool as it was measured. It keeps the readings, since what they say depends on the model: for another
/// one it is computed again.
struct ToolFile {
  int number = 1;                                                  ///< of TOOL_DATA
  std::string arm;                                                 ///< name of the nominal robot
  std::string serial{};                                            ///< of the arm; empty: not known
  Eigen::Isometry3d X_controller = Eigen::Isometry3d::Identity();  ///< what the controller has in TOOL_DATA
  FrameReadings data;
};

/// A work frame in the robot base, as it was measured under one model.
struct BaseFile {
  int number = 1;     ///< of BASE_DATA
  std::string arm;    ///< name of the nominal robot
  std::string model;  ///< when the model was made that it holds for, RFC 3339
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  std::optional<PoseCovariance> covariance{};
  FrameReadings data{};
  /// Where the TCP that touched the points is on the flange; none: the tracker read them.
  std::optional<Eigen::Vector3d> touched_by_mm{};
};

/// A point of a tool or a fixture that is to be measured.
struct PlannedPoint {
  std::string name;
  std::optional<Eigen::Vector3d> at_mm;     ///< where it is, roughly
  std::optional<Eigen::Vector3d> known_mm;  ///< its coordinates in the frame
};

/// Reads points to measure (CSV: point; x,y,z and px,py,pz where they are given). Either all have coordinates
/// of a kind, or none. Throws ConfigError.
std::vector<PlannedPoint> load_points(const std::filesystem::path& file,
                                      const TableReading* reading = nullptr);

/// Reads what was measured (CSV: q1..qN in deg or mm; x,y,z in mm where the tracker read the point; point:
/// its name, "origin" without it; px,py,pz in mm where its coordinates in the frame are known; kTurnColumns
/// of a tool's reading by a 6-D target). Throws ConfigError.
/// @param of_arm  the points are on the arm, so that q1..qN are needed where the tracker read them too
/// @param table_reading  of files that other programs wrote too; null: in this form only
FrameReadings load_frame_readings(const std::filesystem::path& file, const RobotModel& robot, bool of_arm,
                                  const TableReading* table_reading = nullptr);

/// Writes readings as that reads them, every number with the digits that bring it back exactly. All are of
/// one kind: seen by the tracker, or touched; and either all their points have coordinates, or none:
/// std::bad_optional_access otherwise.
void write_frame_readings(std::ostream& out, const FrameReadings& data, const RobotModel& robot);

/// The frame, rounded to the digits of KUKA's display: 0.1 um and 0.00001 deg.
Eigen::Isometry3d rounded_for_controller(const Eigen::Isometry3d& X);

/// Text of such a file, with its hash (sealed()).
std::string tool_yaml(const ToolFile& tool);
/// Refuses one of another arm, or whose text is not the one that was written. Throws ConfigError.
ToolFile load_tool(const std::filesystem::path& file, const RobotModel& robot);
/// The same from a text. @param name  of it, in messages
ToolFile parse_tool(const std::string& text, const std::string& name, const RobotModel& robot);
std::string base_yaml(const BaseFile& base);
/// Refuses one of another arm, measured under another model, or whose readings give another frame. Throws
/// ConfigError.
BaseFile load_base(const std::filesystem::path& file, const ModelFile& model);

/// By what frames are measured with a model. Nothing where neither it nor the caller tells the noise.
std::optional<MeasuringCell> measuring_cell(const ModelFile& model,
                                            const std::optional<MeasurementNoise>& stated = {});

/// What the tool's readings say under a model. Errors: those of tool_frame(), readings that contradict each
/// other, and readings that give another frame than the one in the file: by more than 2 mm or 0.2 deg, which
/// two models of an arm do not differ by.
std::expected<MeasuredFrame, std::string> tool_under(const MeasuringCell& by, const ToolFile& tool);

}  // namespace truepose::config
