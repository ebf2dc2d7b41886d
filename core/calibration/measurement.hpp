#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/kinematics/robot_model.hpp"

namespace truepose {

/// What a measured pose is for. Validation poses never touch the identification.
enum class PoseSet { Identify, Validate };

/// One reflector reading of a standing arm.
struct Measurement {
  JointVector q;                     ///< joint positions (rad, mm)
  Eigen::Vector3d p_WS_mm{0, 0, 0};  ///< reflector centre in the tracker frame
  int smr = 0;                       ///< index into MeasurementData::smr_names
  PoseSet set = PoseSet::Identify;
  std::optional<double> sigma_mm;      ///< standard uncertainty per axis, where known
  std::vector<std::int8_t> direction;  ///< side from which each joint arrived (-1, 0, 1); empty = unknown
  std::string time;                    ///< RFC 3339, or empty
  int row = 0;                         ///< row of the file it came from (1 = first data row), 0 = no file
};

struct MeasurementData {
  std::vector<std::string> smr_names;  ///< in the order of first appearance
  std::vector<Measurement> points;
};

/// The number of each point's pose, from 0 in the order of first appearance. Points with the same joints are
/// of one pose.
std::vector<int> pose_numbers(std::span<const Measurement> points);

/// Indices of the points of each pose, poses in the same order.
std::vector<std::vector<std::size_t>> pose_groups(std::span<const Measurement> points);

int count_poses(std::span<const Measurement> points);

/// The points of one set, in their order.
std::vector<Measurement> points_of(const MeasurementData& data, PoseSet set);

}  // namespace truepose
