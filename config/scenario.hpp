#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/text_file.hpp"
#include "core/arm/robot_model.hpp"
#include "core/plan/scene.hpp"
#include "core/simulate/tracker_instrument.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose::config {

/// How the simulated cell misbehaves at one time of its life, or again and again.
struct ScenarioFault {
  enum class Kind {
    BeamBreak,
    TrackerRestart,
    TrackerBump,    ///< the tracker is pushed: everything it sees is moved by `by_mm` from then on
    TrackerBias,    ///< what it measures is off by `by_mm`
    TrackerNoise,   ///< scatters by `sigma_mm` more, which its own standard deviations show
    TrackerStd,     ///< reports `std_mm`, whatever its standard deviations are
    TrackerStray,   ///< its search finds another reflector, `by_mm` from ours
    TrackerAir,     ///< reports this weather
    TrackerBusy,    ///< answers every command that it is busy
    TrackerSilent,  ///< takes commands, and answers none
    TrackerStorm,   ///< reports changes of its state without end
    EkiDrop,
    ProgramStop,        ///< STOP at the pendant; started again after `lasts`
    ProgramReset,       ///< cancelled and started from its first line
    ProgramSelect,      ///< `program` is selected and started in place of the one that was
    EmergencyStop,      ///< pressed; released, and the program started again, after `lasts`
    GateOpen,           ///< operator safety; closed, and the program started again, after `lasts`
    OperatingMode,      ///< the key turned to `mode`, and back after `lasts`
    Override,           ///< $OV_PRO set to `percent`, and back after `lasts`
    ControllerRestart,  ///< switched off, and on after `lasts`
    RsiDrop,            ///< no datagram gets through, either way
    RsiLoseDatagrams,   ///< none from the controller
    RsiLoseReplies,     ///< none to it
    RsiDuplicate,       ///< the controller's datagrams come twice
    RsiLate,            ///< each datagram of the controller comes a cycle late
    RsiCorrupt,         ///< a byte of each is another one
    RsiReorder,         ///< of two datagrams the later one comes first
    RsiSilence,         ///< the controller sends nothing, keeps what is in effect, and its clock continues
    RsiRestart,         ///< RSI is off, and then on with nothing in effect, from another port
    RsiIpoc,            ///< the time stamp jumps by `ipoc_by`
    RsiIgnore,          ///< replies are taken and move nothing
    RsiSecondSender,    ///< a controller of the same kind sends to the same port of the PC
  };
  /// What `at`, `lasts` and `every` count: ms of scaled time since the start, the RSI controller's cycles and
  /// the tracker's points of the simulator's life, both from 1.
  enum class Unit { Milliseconds, Cycles, Points };

  Kind kind = Kind::BeamBreak;
  Unit unit = Unit::Milliseconds;
  std::int64_t at = 0;
  std::int64_t lasts = 0;  ///< 0 = to the end, where it is not a matter of a moment
  std::int64_t every = 0;  ///< and again after so many; 0 = once

  Eigen::Vector3d by_mm{0, 0, 0};
  double sigma_mm = 0;
  double std_mm = 0;
  double temperature_c = 20, pressure_mbar = 1013.25, humidity_percent = 50;
  std::int64_t ipoc_by = 0;
  std::optional<std::uint64_t> ipoc;  ///< RsiRestart: its first time stamp; else the clock has gone on
  std::string from;                   ///< RsiSecondSender: its numeric address; empty = as the first's
  std::string program;                ///< ProgramSelect
  int percent = 100;                  ///< Override
  enum class Mode { T1 = 1, T2, Aut, Ext } mode = Mode::Ext;  ///< OperatingMode

  bool begins_with(std::int64_t count) const {
    return count == at || (every > 0 && count > at && (count - at) % every == 0);
  }
  bool covers(std::int64_t count) const {
    if (count < at) return false;
    return lasts == 0 || (every > 0 ? (count - at) % every : count - at) < lasts;
  }
};

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
  std::string reflector_name = "CCR-1.5in";

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

/// Reads one fault, a map of YAML or JSON on one line, that begins now. Throws ConfigError.
ScenarioFault parse_fault(const std::string& text);

/// Reads a scenario (YAML) and the robot file that it names. `truth` is nominal + `errors` (a list per link
/// of {a, alpha, d, theta, beta}; mm and rad), or drawn from `errors: {seed: N, mm: 0.5, rad: 0.003}`; with
/// `drives`, its joints also err as heavy_arm_errors() says. Throws ConfigError.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace truepose::config
