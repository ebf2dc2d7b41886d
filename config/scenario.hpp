#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/scenario_fault.hpp"
#include "config/text_file.hpp"
#include "core/arm/robot_model.hpp"
#include "core/plan/scene.hpp"
#include "core/simulate/tracker_instrument.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose::config {

/// A target whose orientation the tracker measures too (T-Mac, STS).
struct SixDTarget {
  Eigen::Matrix3d R_FT = Eigen::Matrix3d::Identity();  ///< of its axes in the flange frame
  double sigma_rad = 0;  ///< standard deviation of a rotation about each axis, as measured and as reported
};

/// What the simulated cell really is, and how it misbehaves. mm and rad inside, deg in the file.
struct Scenario {
  RobotModel nominal;         ///< what the controller believes
  RobotModel truth;           ///< how the arm really is
  NonGeometricErrors drives;  ///< other errors of its joints
  WarmUp warm_up;             ///< and what becomes of it from the start of the simulator, in scaled time
  double repeatability_mm = 0.0166;  ///< standard deviation per axis of the reflector, drawn at each stop
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};
  double acceptance_deg = 30;
  std::optional<SixDTarget> target_6d;            ///< that the reflector is part of; a bridge reports it
  std::vector<TrueReflector> further_reflectors;  ///< on the same flange
  /// What hides a reflector from the tracker: the arm's body and its tool, that count from link 1. Empty:
  /// nothing.
  std::vector<BodyPart> body;
  std::string robot_model = "#KR210R2700_2";
  int robot_serial = 210001;
  std::filesystem::path controller_files;       ///< with eki/, krl/ and rsi/; empty: what truepose ships
  std::filesystem::path archive;                ///< of a controller, a folder or .zip; empty: none
  std::vector<std::filesystem::path> programs;  ///< of the cell's own, .src and .dat
  /// System variables and subprograms, in capitals, that do not stop the advance run: of most no manual says
  /// whether they do. Here they do.
  std::vector<std::string> pass_advance_run;
  std::string selected = "TRUEPOSE_MOTION";  ///< the program that runs at first
  double operator_s = 2;  ///< from HALT or a stop by RSI until the operator acknowledges and starts again

  /// Standard deviation of a tracker reading: constant + per metre of distance, along and across the beam.
  struct TrackerNoise {
    double range_mm = 0.010, range_mm_per_m = 0;
    double transverse_mm = 0.010, transverse_mm_per_m = 0;
  } noise;

  Eigen::Vector3d bias_mm{0, 0, 0};  ///< of every measurement
  std::optional<double> std_mm;      ///< that the tracker reports, whatever its standard deviations are
  /// The weather that the tracker reports.
  struct Air {
    double temperature_c = 20, pressure_mbar = 1013.25, humidity_percent = 50;
  } air;
  bool power_lock = false;  ///< the tracker locks by itself to a reflector that it sees
  TrackerInstrument instrument;

  std::chrono::milliseconds cycle{4};  ///< RSI
  // In place of what the RSI context says:
  std::optional<int> rsi_timeout_cycles;      ///< late or missing replies in a row before KSS29002
  std::optional<double> axis_corr_limit_deg;  ///< AXISCORR clamps silently
  std::optional<int> rsi_decimals;            ///< the ETHERNET object's Precision

  std::filesystem::path ethernet_xml;
  double dead_time_ms = 12;         ///< of the drives, from a set point to the first motion
  std::vector<double> lag_ms{40};   ///< of the drives, time constant of all axes or of each
  std::optional<bool> hold_on;      ///< in place of what the ethernet file says
  bool ignores_correction = false;  ///< the replies are taken and move nothing
  bool consecutive_delay = false;   ///< Delay counts cycles in a row without a reply, not all of the session
  std::uint16_t rsi_source_port = 0;     ///< 0: another one with each session
  std::optional<RobotModel> rsi_arm;     ///< that RIst and RSol are of, where it is not the nominal one
  std::vector<JointVector> stream_path;  ///< visited in a loop while RSI_MOVECORR waits, as no real arm does

  std::vector<ScenarioFault> faults;
};

/// Reads a scenario (YAML) and the robot file that it names. `truth` is nominal + `errors` (a list per link
/// of {a, alpha, d, theta, beta}; mm and rad), or drawn from `errors: {seed: N, mm: 0.5, rad: 0.003}`; with
/// `drives`, its joints also err as heavy_arm_errors() says. Throws ConfigError.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace truepose::config
