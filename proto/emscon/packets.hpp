#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "proto/emscon/emscon_error.hpp"
#include "proto/emscon/enums.hpp"

/// Packets of the Leica emScon TCP protocol (TPI 3.6): little-endian, gaps nowhere, the size of the whole
/// packet first. Lengths, angles and weather are in whatever units SetUnits has chosen, coordinates in the
/// chosen coordinate system.
namespace truepose::emscon {

// ---- Bodies: what follows the head of a command or an answer. Set and get of one thing share one body. ----

struct Units {
  LengthUnit length = LengthUnit::Meter;
  AngleUnit angle = AngleUnit::Radian;
  TemperatureUnit temperature = TemperatureUnit::Celsius;
  PressureUnit pressure = PressureUnit::Mbar;
  HumidityUnit humidity = HumidityUnit::RelativePercent;
  bool operator==(const Units&) const = default;
};

struct SystemStatus {
  std::int32_t last_result = 0;
  ProcessorStatus processor = ProcessorStatus::NotFound;
  LaserStatus laser = LaserStatus::NotAvailable;
  AdmStatus adm = AdmStatus::None;
  std::array<std::int32_t, 3> server_version{};  ///< major, minor, build
  WeatherMonitor weather = WeatherMonitor::NotConnected;
  std::int32_t flags = 0;
  std::int32_t serial_number = 0;
  bool operator==(const SystemStatus&) const = default;
};

struct TrackerStatus {
  TrackerReadiness readiness = TrackerReadiness::NotReady;
  bool operator==(const TrackerStatus&) const = default;
};

struct StationOrientation {
  std::array<double, 3> position{}, rotation{};
  bool operator==(const StationOrientation&) const = default;
};

struct Transformation {
  std::array<double, 3> shift{}, rotation{};
  double scale = 1;
  bool operator==(const Transformation&) const = default;
};

struct Environment {
  double temperature = 0, pressure = 0, humidity = 0;
  bool operator==(const Environment&) const = default;
};

struct MeasurementModeChoice {
  MeasurementMode mode = MeasurementMode::Stationary;
  bool operator==(const MeasurementModeChoice&) const = default;
};

struct CoordinateSystemChoice {
  CoordinateSystem system = CoordinateSystem::Rhr;
  bool operator==(const CoordinateSystemChoice&) const = default;
};

struct StationaryModeParams {
  std::int32_t measure_ms = 0;
  bool use_adm = true;  ///< ignored by AT4xx
  bool operator==(const StationaryModeParams&) const = default;
};

struct ReflectorChoice {
  std::int32_t id = 0;
  bool operator==(const ReflectorChoice&) const = default;
};

/// One answer to GetReflectors; the tracker sends `total` of them.
struct ReflectorEntry {
  std::int32_t total = 0;
  std::int32_t id = 0;
  TargetKind kind = TargetKind::Unknown;
  double surface_offset = 0;
  std::string name;  ///< UTF-8, at most 32 UTF-16 units
  bool operator==(const ReflectorEntry&) const = default;
};

struct SearchParams {
  double radius = 0;
  std::int32_t timeout_ms = 0;
  bool operator==(const SearchParams&) const = default;
};

struct SystemSettings {
  WeatherMonitor weather = WeatherMonitor::NotConnected;
  bool apply_transformation = false;
  bool apply_station_orientation = false;
  bool keep_last_position = false;  ///< the beam stays where it lost the reflector
  bool send_unsolicited_messages = false;
  bool send_reflector_position = false;
  std::int32_t try_mode = 0;
  bool has_nivel = false;
  bool has_video_camera = false;
  bool operator==(const SystemSettings&) const = default;
};

struct Position {
  std::array<double, 3> v{};
  bool use_adm = true;
  bool operator==(const Position&) const = default;
};

struct SearchDistance {
  double distance = 0;  ///< approximate
  bool operator==(const SearchDistance&) const = default;
};

struct Direction {
  double horizontal = 0, vertical = 0;
  bool operator==(const Direction&) const = default;
};

struct StatisticMode {
  StatisticKind stationary = StatisticKind::Standard, continuous = StatisticKind::Standard;
  bool operator==(const StatisticMode&) const = default;
};

struct MeasurementStatusInfo {
  std::int32_t last_result = 0;
  std::int32_t mask = 0;  ///< kReflectorFoundBit, kInitializedBit, ...
  bool operator==(const MeasurementStatusInfo&) const = default;
};

/// Of GetTrackerInfo only what identifies the instrument; its ranges are skipped, and written as zero.
struct TrackerInfo {
  std::int32_t type = 0;
  std::string name;  ///< UTF-8, at most 32 UTF-16 units
  bool operator==(const TrackerInfo&) const = default;
};

/// Refractive indices of the air for the two distance meters.
struct Refraction {
  double ifm_index = 1;
  double adm_index = 1;
  bool operator==(const Refraction&) const = default;
};

struct ContinuousTimeParams {
  std::int32_t separation_ms = 0;
  std::int32_t points = 0;  ///< 0 = endless
  bool use_region = false;
  std::int32_t region = 0;  ///< 0 sphere, 1 box
  bool operator==(const ContinuousTimeParams&) const = default;
};

struct ContinuousDistanceParams {
  double separation = 0;
  std::int32_t points = 0;  ///< 0 = endless
  bool use_region = false;
  std::int32_t region = 0;  ///< 0 sphere, 1 box
  bool operator==(const ContinuousDistanceParams&) const = default;
};

struct AdmParams {
  double stability_tolerance = 0;
  std::int32_t retry_frame_ms = 0;
  std::int32_t retries = 0;
  bool operator==(const AdmParams&) const = default;
};

struct FaceAnswer {
  std::int32_t face = 0;  ///< 1 or 2; 0 = not known
  bool operator==(const FaceAnswer&) const = default;
};

/// A point without the choice of a distance meter.
struct Aim {
  std::array<double, 3> v{};
  bool operator==(const Aim&) const = default;
};

/// Percent.
struct MoveSpeeds {
  std::int32_t horizontal = 0;
  std::int32_t vertical = 0;
  bool operator==(const MoveSpeeds&) const = default;
};

struct TargetSearch {
  std::array<double, 3> v{};
  double radius = 0;
  bool operator==(const TargetSearch&) const = default;
};

struct BirdBathCheck {
  std::array<double, 3> initial{}, difference{};  ///< horizontal, vertical, distance
  bool operator==(const BirdBathCheck&) const = default;
};

struct ParameterId {
  std::int32_t id = 0;
  bool operator==(const ParameterId&) const = default;
};

struct LongParameter {
  std::int32_t id = 0;
  std::int32_t value = 0;
  bool operator==(const LongParameter&) const = default;
};

struct DoubleParameter {
  std::int32_t id = 0;
  double value = 0;
  bool operator==(const DoubleParameter&) const = default;
};

struct ObjectTemperature {
  double temperature = 0;
  bool operator==(const ObjectTemperature&) const = default;
};

struct TurnDirection {
  bool clockwise = false;
  bool operator==(const TurnDirection&) const = default;
};

struct QueueChoice {
  std::int32_t of_all = 0;  ///< 0 own, 1 of all clients
  bool operator==(const QueueChoice&) const = default;
};

struct SoftwareVersion {
  std::string name;  ///< UTF-8, at most 32 UTF-16 units
  bool operator==(const SoftwareVersion&) const = default;
};

/// Of GetAT4xxInfo only what says how well it measures; the rest is skipped, and written as zero.
struct At4xxInfo {
  std::int32_t min_measure_ms = 0;
  double min_distance = 0, max_distance = 0;
  double adm_offset_std = 0;
  double angle_std_constant = 0, angle_std_offset = 0, angle_std_factor = 0;
  bool operator==(const At4xxInfo&) const = default;
};

using Body =
    std::variant<std::monostate, Units, SystemStatus, TrackerStatus, StationOrientation, Transformation,
                 Environment, MeasurementModeChoice, CoordinateSystemChoice, StationaryModeParams,
                 ReflectorChoice, ReflectorEntry, SearchParams, SystemSettings, Position, SearchDistance,
                 Direction, StatisticMode, MeasurementStatusInfo, TrackerInfo, Refraction,
                 ContinuousTimeParams, ContinuousDistanceParams, AdmParams, FaceAnswer, Aim, MoveSpeeds,
                 TargetSearch, BirdBathCheck, ParameterId, LongParameter, DoubleParameter, ObjectTemperature,
                 TurnDirection, QueueChoice, SoftwareVersion, At4xxInfo>;

// ---- Packets ----

/// Client to tracker. The body is the one of its code; none where the code is not known.
struct Command {
  CommandCode code{};
  Body body;
  bool operator==(const Command&) const = default;
};

/// Tracker to client. A refusal (status not 0) carries no body.
struct Answer {
  CommandCode code{};
  std::int32_t status = 0;
  Body body;
  bool operator==(const Answer&) const = default;
};

/// An error at any time; `code` is the command that caused it, or CommandCode::Unknown.
struct ErrorReport {
  CommandCode code = CommandCode::Unknown;
  std::int32_t status = 0;
  bool operator==(const ErrorReport&) const = default;
};

struct SystemStatusChange {
  SystemEvent event{};
  bool operator==(const SystemStatusChange&) const = default;
};

/// Result of a stationary measurement. Weather is what the tracker used.
struct SingleMeasResult {
  std::int32_t status = 0;
  MeasurementMode mode = MeasurementMode::Stationary;
  std::int32_t try_mode = 0;
  std::array<double, 3> v{}, std{};
  double std_total = 0;
  std::array<double, 3> pointing_error{}, apriori_std{};
  double apriori_total = 0;
  Environment environment{};
  bool operator==(const SingleMeasResult&) const = default;
};

/// The same with covariances, where the statistic mode is extended.
struct SingleMeasResult2 {
  std::int32_t status = 0;
  MeasurementMode mode = MeasurementMode::Stationary;
  std::int32_t try_mode = 0;
  std::array<double, 3> v{}, std{};
  double std_total = 0;
  std::array<double, 3> covariance{};  ///< 12, 13, 23
  std::array<double, 3> pointing_error{}, apriori_std{};
  double apriori_total = 0;
  std::array<double, 3> apriori_covariance{};
  Environment environment{};
  bool operator==(const SingleMeasResult2&) const = default;
};

struct MultiMeasPoint {
  std::int32_t status = 0;
  std::int32_t seconds = 0, microseconds = 0;  ///< of the tracker's free-running clock
  std::array<double, 3> v{};
  bool operator==(const MultiMeasPoint&) const = default;
};

struct MultiMeasResult {
  std::int32_t status = 0;
  MeasurementMode mode = MeasurementMode::ContinuousTime;
  std::int32_t try_mode = 0;
  Environment environment{};
  std::vector<MultiMeasPoint> points;
  bool operator==(const MultiMeasResult&) const = default;
};

/// Live position while locked. Not a measurement.
struct ReflectorPosResult {
  std::int32_t status = 0;
  std::array<double, 3> v{};
  bool operator==(const ReflectorPosResult&) const = default;
};

struct NivelResult {
  std::int32_t status = 0;
  std::int32_t nivel_status = 0;
  double x_tilt = 0, y_tilt = 0, temperature = 0;
  bool operator==(const NivelResult&) const = default;
};

/// A packet of a type that we have no use for; not an error.
struct Unknown {
  std::int32_t type = 0;
  bool operator==(const Unknown&) const = default;
};

using ClientPacket = std::variant<Command, Unknown>;
using TrackerPacket =
    std::variant<Answer, ErrorReport, SystemStatusChange, SingleMeasResult, SingleMeasResult2,
                 MultiMeasResult, ReflectorPosResult, NivelResult, Unknown>;

/// @param packet  one whole packet, as PacketSplitter gives it
/// Errors: another size than the layout's (so a server that packs its structs otherwise is found out, not
/// misread).
std::expected<TrackerPacket, EmsconError> decode_tracker_packet(std::span<const std::uint8_t> packet);
std::expected<ClientPacket, EmsconError> decode_client_packet(std::span<const std::uint8_t> packet);

/// The body must be the one of the code (asserted).
std::vector<std::uint8_t> encode(const Command& command);
/// The body must be the one of the code, or none where the status is not 0 (asserted).
std::vector<std::uint8_t> encode(const Answer& answer);
std::vector<std::uint8_t> encode(const ErrorReport& packet);
std::vector<std::uint8_t> encode(const SystemStatusChange& packet);
std::vector<std::uint8_t> encode(const SingleMeasResult& packet);
std::vector<std::uint8_t> encode(const SingleMeasResult2& packet);
std::vector<std::uint8_t> encode(const MultiMeasResult& packet);
std::vector<std::uint8_t> encode(const ReflectorPosResult& packet);
std::vector<std::uint8_t> encode(const NivelResult& packet);

}  // namespace truepose::emscon
