#pragma once

#include <Eigen/Geometry>
#include <array>
#include <boost/json/fwd.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/frame_file.hpp"
#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "core/arm/robot_model.hpp"
#include "core/choices.hpp"
#include "core/data/measurement.hpp"
#include "core/math/refraction.hpp"
#include "core/named.hpp"
#include "core/plan/scene.hpp"
#include "core/plan/test_cube_poses.hpp"
#include "core/quality/iso9283.hpp"

namespace truepose::config {

/// How a controller is reached and which arm it must be.
struct RobotConfig {
  std::filesystem::path file;  ///< robot file
  RobotModel model;            ///< read from it
  std::vector<BodyPart> body;  ///< what the arm and its tool occupy
  Endpoint eki_motion;         ///< channel CellLink
  Endpoint eki_state;          ///< channel CellState
  std::string rsi_peer;        ///< host from which the controller sends RSI packets
  std::string expect_model;    ///< part of the controller's own name of the arm; empty = not checked
  double max_fk_deviation_mm =
      1;  ///< RIst against nominal kinematics of AIPos: beyond this the arm is refused
  double repeatability_mm = 0.0166;  ///< standard deviation per axis of the arm's position
};

enum class RealtimePolicy { Require, Prefer, Off };

/// Whether corrections continue by themselves when a controller that fell silent is back.
enum class Rearm { Manual, Automatic };

/// The correction stream and its bounds (design: safety of the stream).
struct StreamConfig {
  Endpoint listen;                     ///< the PC's RSI address and port
  std::filesystem::path ethernet_xml;  ///< the RSI configuration that the controller loads
  std::chrono::milliseconds cycle{4};
  int timeout_cycles =
      100;  ///< the ETHERNET object's Timeout: the controller gives up after so many without a reply
  Rearm rearm = Rearm::Manual;
  RealtimePolicy realtime = RealtimePolicy::Prefer;
  int priority = 80;
  int cpu = -1;                 ///< of the real-time thread; -1 = any
  double max_step_deg = 0.02;   ///< per cycle and axis
  double max_total_deg = 3.0;   ///< per axis
  double limit_margin_deg = 1;  ///< kept from the joint limits
  double singularity_threshold_deg =
      20;  ///< angle between axes 4 and 6 below which orientation may be given up
  /// Whose position is kept there, flange frame, where no measured tool is in effect; none: the reflector's.
  std::optional<Eigen::Vector3d> p_FT_mm;
  std::optional<int> tool;  ///< in effect, by its number; none: the one that the controller says
  std::chrono::milliseconds ramp{1000};
};

/// What is spoken with a tracker.
enum class TrackerProtocol {
  Emscon,
  Bridge,  ///< a program on the maker's SDK (docs/trackers.md)
};
inline constexpr std::array kTrackerProtocols{Named{"emscon", TrackerProtocol::Emscon},
                                              Named{"bridge", TrackerProtocol::Bridge}};

struct TrackerConfig {
  TrackerProtocol protocol = TrackerProtocol::Emscon;
  Endpoint address;
  std::string reflector;  ///< the tracker's own name of the SMR type; empty = the first
  std::chrono::milliseconds measure{2000};
  /// The next connection initialises the tracker again when it has been switched on for this long. 0: only
  /// when it reports that it has warmed up.
  std::chrono::minutes reinitialise_after{0};
  double first_search_radius_mm = 300;  ///< search radius before base and reflector are known
  double search_radius_mm = 30;         ///< afterwards
  double gate_mm = 25;  ///< a point farther than this from its prediction is a wrong reflector
  Eigen::Isometry3d robot_base =
      Eigen::Isometry3d::Identity();  ///< rough X_WB: where the base stands for the tracker
  TrackerNoiseModel noise{.range_mm = 0.01, .transverse_mm_per_m = 0.003};
  double max_std_mm = 0;  ///< of a measurement, by its own account; 0: several times the noise that is stated
  /// Nests: fixed reflectors near the arm, at approximate positions in the tracker's frame. None, or at least
  /// three.
  std::vector<Eigen::Vector3d> nests_mm;
  std::optional<Air> air;  ///< that was entered; none: air_file's, or what the tracker knows by itself
  std::filesystem::path air_file;          ///< that a weather station keeps up to date; empty: none
  std::chrono::seconds air_max_age{3600};  ///< of what that file says
  double beam_radius_mm = 25;              ///< kept free around the beam
};

struct ReflectorConfig {
  std::string name = "1";
  Eigen::Vector3d p_FS_mm{0, 0, 0};   ///< rough position in the flange frame
  Eigen::Vector3d facing_F{0, 0, 1};  ///< direction of its opening in the flange frame
  double acceptance_deg = 30;         ///< half angle of the cone in which it can be seen
};

enum class ApproachSide {
  Any,        ///< by the shortest way
  Upwards,    ///< every joint arrives moving upwards, so that its backlash always lies on one side
  Alternate,  ///< upwards and downwards in turn, so that backlash can be identified
};

struct CampaignConfig {
  int identify_poses = 30;
  int validate_poses = 30;
  int drift_poses = 5;   ///< of a drift check
  int coarse_after = 8;  ///< poses before the first coarse fit
  std::uint64_t seed = 0;
  double speed_percent = 50;
  std::chrono::milliseconds settle{500};
  std::chrono::seconds warm_up{0};
  int warm_up_moves = 2;
  int retries = 2;  ///< of a failed point, before it is skipped and listed; of connecting
  std::chrono::seconds pause_after{120};  ///< that a campaign waits for a device before it pauses
  int pause_after_lost = 2;               ///< points in a row that fail for good before it pauses; 0: never
  double limit_margin_deg = 5;            ///< kept from the joint limits by planned poses
  double singularity_margin_deg = 3;      ///< least angle from a singular wrist
  DesignCriterion criterion = DesignCriterion::I;
  int candidates = 2000;         ///< poses among which those to measure are chosen
  int nests_every = 10;          ///< poses from one measurement of the nests to the next
  bool correct_by_nests = true;  ///< points are brought to where the tracker stood at first
  int two_face_every = 0;        ///< poses from one that is measured in both faces to the next; 0: none
  int reference_every = 10;      ///< poses from one measurement of a reference pose to the next; 0: none
  ApproachSide approach = ApproachSide::Any;
  double approach_deg = 2;  ///< way of every joint from the side from which it arrives
  bool remeasure = true;    ///< reach the validation poses with compensated joints and measure again
};

/// How an ISO 9283 test is measured.
struct Iso9283Config {
  TestCubeRequest cube;
  int cycles = kIso9283Cycles;
  bool variation = false;  ///< come to P1, P2 and P4 along the axes of the base too
};

/// How campaigns identify. The noise is the tracker's and the arm's.
struct CalibrationConfig {
  bool non_geometric = false;  ///< joints' deviations that cross-validation keeps
  std::vector<int> harmonics{1, 2};
  FieldUse field = FieldUse::None;
  Loss loss = Loss::OutlierRejection;
  PriorUse prior = PriorUse::Auto;  ///< whether deviations from the data sheet are taken as small
};

/// The control port for other machines.
struct TlsConfig {
  Endpoint listen;
  std::filesystem::path certificate;  ///< the daemon's, and those up to its CA, in PEM form
  std::filesystem::path key;          ///< private key of it, in PEM form
};

struct ControlConfig {
  Endpoint listen{"127.0.0.1", 7210};
  std::filesystem::path token_file;
  std::optional<TlsConfig> tls{};
};

/// Dashboard, metrics, health, and the control protocol for browsers.
struct WebConfig {
  std::optional<Endpoint> listen{{"127.0.0.1", 7280}};  ///< none: off
  std::vector<std::string> origins{};  ///< of pages of others that may speak the control protocol
};

/// What is kept of the last minutes on the wires.
struct RecordingConfig {
  std::filesystem::path folder;  ///< of the ring, and of the recordings that are written
  std::size_t ring_mb = 64;
  std::size_t max_files = 20;
  std::size_t max_mb = 500;  ///< of all recordings; the newest is kept in any case
};

/// What the flange carries while a tool of the controller is in effect: its LOAD_DATA.
struct ToolLoad {
  int tool = 0;  ///< its number; 0: none in effect, or not known
  LinkMass payload;
};

struct CellConfig {
  std::string name;
  RobotConfig robot;
  std::vector<ToolFile> tools;  ///< that were measured, each of another number
  std::vector<ToolLoad> loads;  ///< each of another number; of others what was carried in the campaigns
  StreamConfig stream;
  TrackerConfig tracker;
  ReflectorConfig reflector;
  std::vector<ReflectorConfig> further_reflectors;  ///< on the same flange, each of another name
  Surroundings surroundings;
  Box workspace;  ///< where the reflector may go; robot base frame
  Box task;       ///< where accuracy matters
  CampaignConfig campaign;
  CalibrationConfig calibration;
  Iso9283Config iso9283;
  ControlConfig control;
  std::optional<WebConfig> web{};  ///< none: as usual, and without it where the port is taken
  RecordingConfig recording;
  std::filesystem::path store;    ///< SQLite file
  std::filesystem::path runtime;  ///< folder of what lives while the machine is up; empty: the usual place
  std::string log_level = "info";
};

/// Reflectors that one flange may carry.
inline constexpr std::size_t kMostReflectors = 6;

/// All of a cell's: the first, then the further ones.
std::vector<ReflectorConfig> reflectors_of(const CellConfig& cell);

/// Null where none was measured that has the number.
const ToolFile* tool_of(const CellConfig& cell, int number);

/// Reads a cell file and every file that it names (relative to it). Throws ConfigError.
CellConfig load_cell(const std::filesystem::path& file);

/// What is in effect, by the keys of the file: all that is set in `loads`, `stream`, `tracker`, `reflectors`,
/// `campaign`, `calibration`, `iso9283` and `recording`, and a few of the other sections; without secrets.
boost::json::object cell_json(const CellConfig& cell);

/// @name What campaigns go by, the sections `campaign` and `calibration` of a cell, as a text (YAML)
/// @{
std::string campaign_options(const CellConfig& cell);
/// Puts what such a text says in their place. Throws ConfigError.
void use_campaign_options(CellConfig& cell, const std::string& text);
/// @}

/// Puts the arm of another robot file in place of the cell's; the tool's body stays on its flange.
void use_robot(CellConfig& cell, const std::filesystem::path& file);

}  // namespace truepose::config
