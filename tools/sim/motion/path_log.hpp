#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>

#include "core/arm/robot_model.hpp"
#include "core/simulate/joint_motion.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose::sim {

/// The arm in one cycle of a program under RSI.
struct ProgramCycle {
  Seconds time{0};
  std::string program;
  JointVector set_points, correction, actual;
  int gain_percent = 0;  ///< what the PC says in $SEN_PINT[2]
  std::uint64_t motions_made = 0;
  bool is_standing = false;
};

/// What a program under RSI asks of the arm and where the tracker would see the reflector: a CSV file with a
/// row every 20 ms and one at each point where the arm stands. The flange of the data sheet at the set points
/// in the robot's base (mm, KUKA's A, B, C in deg); the reflector as it really is (with), and as it would be
/// if the axes stood at the set points (without), in the tracker's frame, without noise (mm); the axes'
/// set points, the correction in effect and the actual positions (deg).
class PathLog {
 public:
  /// Throws std::runtime_error where the file cannot be written.
  PathLog(const std::filesystem::path& file, RobotModel nominal, TrueArmSetup truth);

  /// May be called from another thread than flush(); does no I/O.
  void take(const ProgramCycle& cycle);
  void flush();

 private:
  bool is_point(const ProgramCycle& cycle);

  RobotModel nominal_;
  TrueArmSetup truth_;
  std::ofstream file_;
  std::uint64_t cycles_ = 0;
  std::uint64_t judged_ = 0;  // motions made, when a point was last written
  JointVector actual_;        // of the cycle before
  std::mutex mutex_;
  std::string rows_;  // guarded by mutex_
};

}  // namespace truepose::sim
