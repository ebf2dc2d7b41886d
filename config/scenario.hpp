#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/config_error.hpp"
#include "core/kinematics/robot_model.hpp"
#include "core/simulation/non_geometric_errors.hpp"

namespace truepose::config {

/// What the simulated cell really is, and how it misbehaves. mm and rad inside, deg in the file.
struct Scenario {
  RobotModel nominal;         ///< what the controller believes
  RobotModel truth;           ///< how the arm really is
  NonGeometricErrors drives;  ///< and what its joints do besides
  double repeatability_mm =
      0.0166;  ///< standard deviation per axis of the reflector, drawn anew at each stop
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};
  double acceptance_deg = 30;
  std::string robot_model = "#KR210R2700_2";
  std::string robot_serial = "SIM-0001";

  /// Standard deviation of a tracker reading: constant + per metre of distance, along and across the beam.
  struct TrackerNoise {
    double range_mm = 0.010, range_mm_per_m = 0;
    double transverse_mm = 0.010, transverse_mm_per_m = 0;
  } noise;
  std::string reflector_name = "CCR-1.5in";

  std::chrono::milliseconds cycle{4};  ///< RSI
  int rsi_timeout_cycles = 100;        ///< late or missing replies in a row before KSS29002
  double axis_corr_limit_deg = 5;      ///< AXISCORR clamps silently
  std::filesystem::path ethernet_xml;
  std::vector<JointVector> stream_path;  ///< programmed points that the RSI program visits in a loop

  /// A fault at a time after the start (of scaled time). kinds: "beam-break", "tracker-restart", "eki-drop",
  /// "rsi-drop".
  struct Fault {
    std::chrono::milliseconds at{0};
    std::string kind;
    std::chrono::milliseconds lasts{0};
  };
  std::vector<Fault> faults;
};

/// Reads a scenario (YAML) and the robot file that it names. `truth` is nominal + `errors` (a list per link
/// of {a, alpha, d, theta, beta}; mm and rad), or drawn from `errors: {seed: N, mm: 0.5, rad: 0.003}`; with
/// `drives`, its joints also err as heavy_arm_errors() says. Throws ConfigError.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace truepose::config
