#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/arm/robot_model.hpp"
#include "core/simulate/joint_motion.hpp"
#include "core/simulate/tracker_instrument.hpp"
#include "core/simulate/true_arm.hpp"
#include "drivers/clock.hpp"

namespace truepose::drivers {

/// Probability of each fault per call that it can befall.
struct MockFaults {
  double tracker_busy = 0;
  double no_target = 0;
  double beam_broken = 0;
  double scattering = 0;       ///< readings that are 3 mm apart, as the tracker itself says
  double wrong_reflector = 0;  ///< a search with a large radius finds another reflector, 60 to 100 mm off
};

struct MockCellOptions {
  RobotModel nominal;  ///< what the controller believes
  TrueArmSetup truth;  ///< how the arm, its base and its reflector really are
  TrackerNoiseModel noise;
  double orientation_sigma_rad = 0;  ///< of the first reflector, a 6-D target; 0: a plain one
  TrackerInstrument instrument;      ///< of which the air plays no part
  JointVector q_start;
  std::string robot_model = "#KR210R2700_2 C4 FLR";
  MockFaults faults;
  std::uint64_t seed = 0;
};

/// The cell that the mock robot and the mock tracker share: the true arm in motion and the true place of its
/// reflector.
class MockCell {
 public:
  MockCell(MockCellOptions options, Clock& clock);

  const MockCellOptions& options() const { return options_; }
  Clock& clock() { return clock_; }
  void use_faults(const MockFaults& faults) { options_.faults = faults; }

  /// Begins a motion that continues whether or not a caller waits for its end.
  void start_motion(const JointVector& q, double speed_percent);
  void stop_motion();
  TimePoint motion_ends() const;
  bool moving() const { return clock_.now() < motion_ends(); }
  JointVector q() const;

  std::size_t reflectors() const { return arm_.reflectors(); }
  /// Where a reflector really is, repeatability of the last stop included.
  Eigen::Vector3d p_WS_mm(std::size_t reflector = 0) const {
    return arm_.p_WS_mm(q(), reflector) + bumped_mm_;
  }
  bool visible(std::size_t reflector = 0) const { return arm_.visible(q(), reflector); }
  Eigen::Vector3d nest_mm(std::size_t nest) const { return options_.instrument.nests_mm[nest] + bumped_mm_; }
  /// What the tracker makes of a point, in face 1 or 2.
  Eigen::Vector3d reading_mm(const Eigen::Vector3d& p_mm, int face, const TrackerNoiseModel& noise) {
    return noisy_reading(options_.instrument.aiming.seen(p_mm, face), noise, random_);
  }
  /// The same of the first reflector's orientation; nothing where that is a plain one.
  std::optional<MeasuredOrientation> orientation() {
    const double sigma_rad = options_.orientation_sigma_rad;
    if (sigma_rad <= 0) return std::nullopt;
    return noisy_orientation(arm_.R_WT(q()), sigma_rad, random_);
  }
  /// The tracker was pushed: from now on it sees everything elsewhere.
  void bump_tracker(const Eigen::Vector3d& by_mm) { bumped_mm_ += by_mm; }

  /// Moves the arm's first reflector to another place on the flange.
  void put_reflector(const Eigen::Vector3d& p_FS_mm) { arm_.put_reflector(p_FS_mm); }

  /// The program sets another tool.
  /// @param frame  X Y Z in mm, A B C in deg; none: it does not say
  void use_tool(std::optional<int> number, std::optional<std::array<double, 6>> frame = {}) {
    tool_ = number;
    tool_frame_ = frame;
  }
  std::optional<int> tool() const { return tool_; }
  const std::optional<std::array<double, 6>>& tool_frame() const { return tool_frame_; }

  bool happens(double probability) { return random_.uniform() < probability; }
  double uniform(double min, double max) { return random_.uniform(min, max); }

 private:
  MockCellOptions options_;
  Clock& clock_;
  Random random_;
  TrueArm arm_;
  Eigen::Vector3d bumped_mm_{0, 0, 0};
  std::optional<int> tool_;
  std::optional<std::array<double, 6>> tool_frame_;
  JointVector stand_;  ///< where the arm stands while there is no motion
  std::optional<JointMotion> motion_;
  TimePoint start_;
  TimePoint switched_on_;
};

}  // namespace truepose::drivers
