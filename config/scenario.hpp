#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/config_error.hpp"
#include "config/scenario_fault.hpp"
#include "core/arm/robot_model.hpp"
#include "core/simulate/true_arm.hpp"

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

  Eigen::Vector3d bias_mm{0, 0, 0};  ///< of every measurement
  std::optional<double> std_mm;      ///< that the tracker reports, whatever its standard deviations are
  /// The weather that the tracker reports.
  struct Air {
    double temperature_c = 20, pressure_mbar = 1013.25, humidity_percent = 50;
  } air;
  bool power_lock = false;  ///< the tracker locks by itself to a reflector that it sees

  std::chrono::milliseconds cycle{4};  ///< RSI
  int rsi_timeout_cycles = 100;        ///< late or missing replies in a row before KSS29002
  double axis_corr_limit_deg = 5;      ///< AXISCORR clamps silently
  std::filesystem::path ethernet_xml;
  double dead_time_ms = 12;         ///< of the drives, from a set point to the first motion
  std::vector<double> lag_ms{40};   ///< of the drives, time constant of all axes or of each
  std::optional<bool> hold_on;      ///< in place of what the ethernet file says
  bool ignores_correction = false;  ///< the replies are taken and move nothing
  bool consecutive_delay = false;   ///< Delay counts cycles in a row without a reply, not all of the session
  int rsi_decimals = 4;             ///< the ETHERNET object's Precision
  std::uint16_t rsi_source_port = 0;     ///< 0: another one with each session
  std::optional<RobotModel> rsi_arm;     ///< that RIst and RSol are of, where it is not the nominal one
  std::vector<JointVector> stream_path;  ///< programmed points that the RSI program visits in a loop

  std::vector<ScenarioFault> faults;
};

/// Reads a scenario (YAML) and the robot file that it names. `truth` is nominal + `errors` (a list per link
/// of {a, alpha, d, theta, beta}; mm and rad), or drawn from `errors: {seed: N, mm: 0.5, rad: 0.003}`; with
/// `drives`, its joints also err as heavy_arm_errors() says. Throws ConfigError.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace truepose::config
