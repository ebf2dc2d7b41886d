#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "config/cell_config.hpp"
#include "core/plan/pose_supply.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/threads/worker.hpp"

namespace truepose::daemon {

/// The way (rad) by which every joint comes to a pose, from below where positive;
/// 0 where the campaign prescribes no side.
double approach_way_rad(const config::CampaignConfig& campaign, int pose);

/// In which each joint moved last (-1, 1; 0 or empty: not known), after one more way: a joint that hardly
/// moves on it keeps its direction.
std::vector<std::int8_t> direction_after(std::vector<std::int8_t> direction, const JointVector& way);

/// Moves the arm by ways that are clear, as far as its surroundings are known, and remembers from which side
/// each joint came.
class ArmMotion {
 public:
  /// @param robot, devices  outlive it
  ArmMotion(const RobotModel& robot, CellDevices& devices, RunJob compute)
      : robot_{robot}, devices_{devices}, compute_{std::move(compute)} {}

  /// Needed before the first motion.
  void use_paths_of(std::shared_ptr<PoseSupply> poses) { poses_ = std::move(poses); }

  /// @return the actual joint positions at the end
  CellDevices::Outcome<JointVector> drive(JointVector q);
  /// The same by way of a place from which all joints move up (or down, where `way_rad` is negative) to q.
  CellDevices::Outcome<JointVector> arrive(JointVector q, double way_rad);

  /// In which each joint last moved: -1, 1; 0 or empty: not known.
  const std::vector<std::int8_t>& direction() const { return direction_; }

 private:
  const RobotModel& robot_;
  CellDevices& devices_;
  RunJob compute_;
  std::shared_ptr<PoseSupply> poses_;
  std::vector<std::int8_t> direction_;
};

}  // namespace truepose::daemon
