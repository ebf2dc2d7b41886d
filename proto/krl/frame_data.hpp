#pragma once

#include <Eigen/Geometry>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "proto/krl/position.hpp"
#include "proto/krl/program_statement.hpp"

namespace truepose::krl {

/// Tools and bases of the controller's $config.dat: TOOL_DATA[n] (TCP in the flange frame) and BASE_DATA[n].
struct FrameData {
  std::map<int, Eigen::Isometry3d> tools, bases;
  std::set<int> moving_bases;  ///< those that an external axis carries (MACHINE_FRAME_DAT)

  /// Those of another file; what is there stays.
  void add(const FrameData& more);
};

FrameData frame_data_of(const TextStatements& statements);

/// "TOOL_DATA[3]={X 100.0,Y 0.0,Z 250.0,A 0.0,B 0.0,C 0.0}"
/// @param table   TOOL_DATA, BASE_DATA or MACHINE_DEF
/// @param member  of the element, as ".ROOT"; empty: the element itself
std::string frame_statement(std::string_view table, int number, const Eigen::Isometry3d& X,
                            std::string_view member = "");

/// The pose (mm) that a Cartesian position writes.
Eigen::Isometry3d pose_of(const Position& position);

}  // namespace truepose::krl
