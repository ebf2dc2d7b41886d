#pragma once

#include <cstddef>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "config/table/csv_reader.hpp"
#include "config/table/table_reading.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// What the rows of a file say of each target.
enum class TargetForm { Joints, Poses, Positions };

/// A row. What the form does not tell is not set.
struct TargetRow {
  std::vector<double> numbers;      ///< q1..qN in deg or mm, x,y,z,a,b,c in mm and deg, or x,y,z in mm
  std::optional<int> status, turn;  ///< KUKA's, of a pose
  JointVector e;                    ///< of the positioner that carries it
};

/// What of a file is taken.
struct TargetRules {
  const RobotModel* arm = nullptr;        ///< that the joints are of; null: there are as many as the file has
  std::optional<bool> of_joints{};        ///< none: joints where the file has q1, otherwise poses
  bool whole_poses_alone = true;          ///< no position without orientation, and no status and turn
  const RobotModel* table = nullptr;      ///< of the positioner that carries the targets; null: none does
  const TableReading* reading = nullptr;  ///< of files that other programs wrote too; null: in our form only
};

/// Targets from CSV, one at a time: q1..qN (kReachColumns are passed over), or x,y,z,a,b,c with KUKA's status
/// and turn (s,t) where they are given, or x,y,z alone; with a table e1..eN of it. Throws ConfigError naming
/// file, row and column.
class TargetReader {
 public:
  /// @param file  stands in the messages
  TargetReader(std::istream& in, const std::string& file, const TargetRules& rules);

  TargetForm form() const { return form_; }
  bool has_status() const { return status_.has_value(); }
  /// Of the last target: its row, the first is 1.
  std::size_t row() const { return rows_.index() + 1; }

  /// The next target, or nothing at the end. There is one at least.
  std::optional<TargetRow> next();

 private:
  std::vector<double> numbers(const std::vector<std::size_t>& columns) const;
  std::optional<int> bits(std::optional<std::size_t> column, int most) const;
  JointVector table_joints() const;

  const RobotModel* table_;
  OpenTable text_;
  CsvStream rows_;
  TargetForm form_;
  std::vector<std::size_t> columns_, table_columns_;
  std::optional<std::size_t> status_, turn_;
};

}  // namespace truepose::config
