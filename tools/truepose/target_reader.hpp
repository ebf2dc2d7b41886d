#pragma once

#include <optional>
#include <vector>

#include "config/csv_reader.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::tools {

/// What the rows of a file say of each target.
enum class TargetForm { Joints, Poses, Positions };

/// One row. What the form does not tell is not set.
struct Target {
  JointVector q;        ///< Joints
  Eigen::Isometry3d X;  ///< Poses; Positions: its translation alone. mm, robot base frame
  std::optional<int> status, turn;
};

/// Targets from CSV, one at a time: q1..qN, or x,y,z,a,b,c (mm, deg) with KUKA's status and turn (s,t) where
/// they are told, or x,y,z alone. Throws ConfigError naming file, row and column.
class TargetReader {
 public:
  TargetReader(std::istream& in, const std::string& file, const RobotModel& robot, bool of_joints);

  TargetForm form() const { return form_; }
  bool has_status() const { return status_.has_value(); }

  /// The next target, or nothing at the end.
  std::optional<Target> next();
  /// Of the last target: its row, the first is 1.
  std::size_t row() const { return rows_.index() + 1; }

 private:
  int bits(std::size_t column, int most) const;

  const RobotModel& robot_;
  config::CsvStream rows_;
  TargetForm form_;
  std::vector<std::size_t> columns_;
  std::optional<std::size_t> status_, turn_;
};

}  // namespace truepose::tools
