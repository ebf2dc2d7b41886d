#include "proto/emscon/packets.hpp"

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

#include "proto/emscon/wire.hpp"

namespace truepose::emscon {
namespace {

/// T or const T, so that one layout reads and writes.
template <class T, class Struct>
concept Is = std::same_as<std::remove_const_t<T>, Struct>;

// ---- Layouts: the fields of each struct in the order of the wire ----

void layout(auto&, Is<std::monostate> auto&) {}
void layout(auto& io, Is<Units> auto& x) { io(x.length, x.angle, x.temperature, x.pressure, x.humidity); }
void layout(auto& io, Is<SystemStatus> auto& x) {
  io(x.last_result, x.processor, x.laser, x.adm, x.server_version, x.weather, x.flags, x.serial_number);
}
void layout(auto& io, Is<TrackerStatus> auto& x) { io(x.readiness); }
void layout(auto& io, Is<StationOrientation> auto& x) { io(x.position, x.rotation); }
void layout(auto& io, Is<Transformation> auto& x) { io(x.shift, x.rotation, x.scale); }
void layout(auto& io, Is<Environment> auto& x) { io(x.temperature, x.pressure, x.humidity); }
void layout(auto& io, Is<MeasurementModeChoice> auto& x) { io(x.mode); }
void layout(auto& io, Is<CoordinateSystemChoice> auto& x) { io(x.system); }
void layout(auto& io, Is<StationaryModeParams> auto& x) { io(x.measure_ms, x.use_adm); }
void layout(auto& io, Is<ReflectorChoice> auto& x) { io(x.id); }
void layout(auto& io, Is<ReflectorEntry> auto& x) {
  io(x.total, x.id, x.kind, x.surface_offset);
  io.name(x.name);
}
void layout(auto& io, Is<SearchParams> auto& x) { io(x.radius, x.timeout_ms); }
void layout(auto& io, Is<SystemSettings> auto& x) {
  io(x.weather, x.apply_transformation, x.apply_station_orientation, x.keep_last_position,
     x.send_unsolicited_messages, x.send_reflector_position, x.try_mode, x.has_nivel, x.has_video_camera);
}
void layout(auto& io, Is<Position> auto& x) { io(x.v, x.use_adm); }
void layout(auto& io, Is<SearchDistance> auto& x) { io(x.distance); }
void layout(auto& io, Is<Direction> auto& x) { io(x.horizontal, x.vertical); }
void layout(auto& io, Is<StatisticMode> auto& x) { io(x.stationary, x.continuous); }
void layout(auto& io, Is<MeasurementStatusInfo> auto& x) { io(x.last_result, x.mask); }
void layout(auto& io, Is<TrackerInfo> auto& x) {
  constexpr std::size_t kRanges = 80;
  io(x.type);
  io.name(x.name);
  io.skip(kRanges);
}
void layout(auto& io, Is<Refraction> auto& x) { io(x.ifm_index, x.adm_index); }
void layout(auto& io, Is<ContinuousTimeParams> auto& x) {
  io(x.separation_ms, x.points, x.use_region, x.region);
}
void layout(auto& io, Is<ContinuousDistanceParams> auto& x) {
  io(x.separation, x.points, x.use_region, x.region);
}
void layout(auto& io, Is<AdmParams> auto& x) { io(x.stability_tolerance, x.retry_frame_ms, x.retries); }
void layout(auto& io, Is<FaceAnswer> auto& x) { io(x.face); }
void layout(auto& io, Is<Aim> auto& x) { io(x.v); }
void layout(auto& io, Is<MoveSpeeds> auto& x) { io(x.horizontal, x.vertical); }
void layout(auto& io, Is<TargetSearch> auto& x) { io(x.v, x.radius); }
void layout(auto& io, Is<BirdBathCheck> auto& x) { io(x.initial, x.difference); }
void layout(auto& io, Is<ParameterId> auto& x) { io(x.id); }
void layout(auto& io, Is<LongParameter> auto& x) { io(x.id, x.value); }
void layout(auto& io, Is<DoubleParameter> auto& x) { io(x.id, x.value); }
void layout(auto& io, Is<ObjectTemperature> auto& x) { io(x.temperature); }
void layout(auto& io, Is<TurnDirection> auto& x) { io(x.clockwise); }
void layout(auto& io, Is<QueueChoice> auto& x) { io(x.of_all); }
void layout(auto& io, Is<SoftwareVersion> auto& x) { io.name(x.name); }
void layout(auto& io, Is<At4xxInfo> auto& x) {
  constexpr std::size_t kBeforeTimes = 116;
  io.skip(kBeforeTimes);
  io(x.min_measure_ms, x.min_distance, x.max_distance, x.adm_offset_std, x.angle_std_constant,
     x.angle_std_offset, x.angle_std_factor);
}

void layout(auto& io, Is<ErrorReport> auto& x) { io(x.code, x.status); }
void layout(auto& io, Is<SystemStatusChange> auto& x) { io(x.event); }
void layout(auto& io, Is<SingleMeasResult> auto& x) {
  io(x.status, x.mode, x.try_mode, x.v, x.std, x.std_total, x.pointing_error, x.apriori_std, x.apriori_total);
  layout(io, x.environment);
}
void layout(auto& io, Is<SingleMeasResult2> auto& x) {
  io(x.status, x.mode, x.try_mode, x.v, x.std, x.std_total, x.covariance, x.pointing_error, x.apriori_std,
     x.apriori_total, x.apriori_covariance);
  layout(io, x.environment);
}
void layout(auto& io, Is<MultiMeasPoint> auto& x) { io(x.status, x.seconds, x.microseconds, x.v); }
void layout(auto& io, Is<ReflectorPosResult> auto& x) { io(x.status, x.v); }
void layout(auto& io, Is<NivelResult> auto& x) {
  io(x.status, x.nivel_status, x.x_tilt, x.y_tilt, x.temperature);
}

constexpr std::size_t kMultiMeasPointSize = 36;

// ---- Which body belongs to which command and its answer ----

struct Bodies {
  Body command, answer;  ///< of the right alternative, otherwise empty
};

std::optional<Bodies> bodies_of(CommandCode code) {
  switch (code) {
    case CommandCode::ExitApplication:
    case CommandCode::Initialize:
    case CommandCode::ReleaseMotors:
    case CommandCode::Park:
    case CommandCode::StartMeasurement:
    case CommandCode::StopMeasurement:
    case CommandCode::StartNivelMeasurement:
    case CommandCode::ChangeFace:
    case CommandCode::GoLastMeasuredPoint:
    case CommandCode::GoBirdBath:
      return Bodies{};
    case CommandCode::GetSystemStatus:
      return Bodies{{}, SystemStatus{}};
    case CommandCode::GetTrackerStatus:
      return Bodies{{}, TrackerStatus{}};
    case CommandCode::SetUnits:
      return Bodies{Units{}, {}};
    case CommandCode::GetUnits:
      return Bodies{{}, Units{}};
    case CommandCode::SetStationOrientationParams:
      return Bodies{StationOrientation{}, {}};
    case CommandCode::GetStationOrientationParams:
      return Bodies{{}, StationOrientation{}};
    case CommandCode::SetTransformationParams:
      return Bodies{Transformation{}, {}};
    case CommandCode::GetTransformationParams:
      return Bodies{{}, Transformation{}};
    case CommandCode::SetEnvironmentParams:
      return Bodies{Environment{}, {}};
    case CommandCode::GetEnvironmentParams:
      return Bodies{{}, Environment{}};
    case CommandCode::SetMeasurementMode:
      return Bodies{MeasurementModeChoice{}, {}};
    case CommandCode::GetMeasurementMode:
      return Bodies{{}, MeasurementModeChoice{}};
    case CommandCode::SetCoordinateSystemType:
      return Bodies{CoordinateSystemChoice{}, {}};
    case CommandCode::GetCoordinateSystemType:
      return Bodies{{}, CoordinateSystemChoice{}};
    case CommandCode::SetStationaryModeParams:
      return Bodies{StationaryModeParams{}, {}};
    case CommandCode::GetStationaryModeParams:
      return Bodies{{}, StationaryModeParams{}};
    case CommandCode::SetReflector:
      return Bodies{ReflectorChoice{}, {}};
    case CommandCode::GetReflector:
      return Bodies{{}, ReflectorChoice{}};
    case CommandCode::GetReflectors:
      return Bodies{{}, ReflectorEntry{}};
    case CommandCode::SetSearchParams:
      return Bodies{SearchParams{}, {}};
    case CommandCode::GetSearchParams:
      return Bodies{{}, SearchParams{}};
    case CommandCode::SetSystemSettings:
      return Bodies{SystemSettings{}, {}};
    case CommandCode::GetSystemSettings:
      return Bodies{{}, SystemSettings{}};
    case CommandCode::GoPosition:
      return Bodies{Position{}, {}};
    case CommandCode::FindReflector:
      return Bodies{SearchDistance{}, {}};
    case CommandCode::GetDirection:
      return Bodies{{}, Direction{}};
    case CommandCode::SetStatisticMode:
      return Bodies{StatisticMode{}, {}};
    case CommandCode::GetMeasurementStatusInfo:
      return Bodies{{}, MeasurementStatusInfo{}};
    case CommandCode::GetTrackerInfo:
      return Bodies{{}, TrackerInfo{}};
    case CommandCode::SetRefractionParams:
      return Bodies{Refraction{}, {}};
    case CommandCode::GetRefractionParams:
      return Bodies{{}, Refraction{}};
    case CommandCode::SetContinuousTimeModeParams:
      return Bodies{ContinuousTimeParams{}, {}};
    case CommandCode::GetContinuousTimeModeParams:
      return Bodies{{}, ContinuousTimeParams{}};
    case CommandCode::SetContinuousDistanceModeParams:
      return Bodies{ContinuousDistanceParams{}, {}};
    case CommandCode::GetContinuousDistanceModeParams:
      return Bodies{{}, ContinuousDistanceParams{}};
    case CommandCode::SetAdmParams:
      return Bodies{AdmParams{}, {}};
    case CommandCode::GetAdmParams:
      return Bodies{{}, AdmParams{}};
    case CommandCode::GoPositionHvd:
      return Bodies{Position{}, {}};
    case CommandCode::PositionRelativeHv:
      return Bodies{Direction{}, {}};
    case CommandCode::PointLaser:
      return Bodies{Aim{}, {}};
    case CommandCode::PointLaserHvd:
      return Bodies{Aim{}, {}};
    case CommandCode::MoveHv:
      return Bodies{MoveSpeeds{}, {}};
    case CommandCode::LookForTarget:
      return Bodies{TargetSearch{}, Direction{}};
    case CommandCode::GetStatisticMode:
      return Bodies{{}, StatisticMode{}};
    case CommandCode::CheckBirdBath:
      return Bodies{{}, BirdBathCheck{}};
    case CommandCode::GoBirdBath2:
      return Bodies{TurnDirection{}, {}};
    case CommandCode::GetFace:
      return Bodies{{}, FaceAnswer{}};
    case CommandCode::SetLongSystemParameter:
      return Bodies{LongParameter{}, {}};
    case CommandCode::GetLongSystemParameter:
      return Bodies{ParameterId{}, LongParameter{}};
    case CommandCode::SetDoubleSystemParameter:
      return Bodies{DoubleParameter{}, {}};
    case CommandCode::GetDoubleSystemParameter:
      return Bodies{ParameterId{}, DoubleParameter{}};
    case CommandCode::GetObjectTemperature:
      return Bodies{{}, ObjectTemperature{}};
    case CommandCode::ClearCommandQueue:
      return Bodies{QueueChoice{}, {}};
    case CommandCode::GoAndMeasure:
      return Bodies{Aim{}, {}};
    case CommandCode::GetAt4xxInfo:
      return Bodies{{}, At4xxInfo{}};
    case CommandCode::GetSystemSoftwareVersion:
      return Bodies{{}, SoftwareVersion{}};
    case CommandCode::Unknown:
      break;
  }
  return std::nullopt;
}

// ---- Heads ----

constexpr std::int32_t kSizeUnknownYet = 0;

Writer begin(PacketType type) {
  Writer writer;
  writer(kSizeUnknownYet, type);
  return writer;
}

std::vector<std::uint8_t> encode_flat(PacketType type, const auto& packet) {
  Writer writer = begin(type);
  layout(writer, packet);
  return std::move(writer).finish();
}

std::optional<EmsconError> check_end(const Reader& reader) {
  if (!reader.ok()) return EmsconError{"packet shorter than its layout", reader.offset()};
  if (reader.remaining() != 0) return EmsconError{"packet longer than its layout", reader.offset()};
  return std::nullopt;
}

void read_body(Reader& reader, Body& body) {
  std::visit([&](auto& alternative) { layout(reader, alternative); }, body);
}

template <class T>
std::expected<TrackerPacket, EmsconError> decode_flat(Reader& reader) {
  T packet;
  layout(reader, packet);
  if (const auto error = check_end(reader)) return std::unexpected(*error);
  return packet;
}

std::expected<TrackerPacket, EmsconError> decode_answer(Reader& reader) {
  Answer answer;
  reader(answer.code, answer.status);
  if (!reader.ok()) return std::unexpected(*check_end(reader));
  const auto bodies = bodies_of(answer.code);
  // Nothing public says whether a refusal keeps the size of the full answer: its body has no meaning either
  // way.
  if (!bodies || answer.status != 0) return answer;
  answer.body = bodies->answer;
  read_body(reader, answer.body);
  if (const auto error = check_end(reader)) return std::unexpected(*error);
  return answer;
}

std::expected<TrackerPacket, EmsconError> decode_multi(Reader& reader) {
  MultiMeasResult result;
  std::int32_t count = 0;
  reader(result.status, count, result.mode, result.try_mode);
  layout(reader, result.environment);
  if (!reader.ok()) return std::unexpected(*check_end(reader));
  if (count < 0 || static_cast<std::size_t>(count) * kMultiMeasPointSize != reader.remaining()) {
    return std::unexpected(EmsconError{"number of points does not fit the packet size", 12});
  }
  result.points.resize(static_cast<std::size_t>(count));
  for (MultiMeasPoint& point : result.points) layout(reader, point);
  return result;
}

/// Size and type, checked against the bytes given.
std::expected<PacketType, EmsconError> read_head(Reader& reader, std::size_t given) {
  std::int32_t size = 0;
  PacketType type{};
  reader(size, type);
  if (!reader.ok()) return std::unexpected(EmsconError{"packet shorter than its head", reader.offset()});
  if (size < 0 || static_cast<std::size_t>(size) != given) {
    return std::unexpected(EmsconError{"size field differs from the bytes given", 0});
  }
  return type;
}

}  // namespace

std::expected<TrackerPacket, EmsconError> decode_tracker_packet(std::span<const std::uint8_t> packet) {
  Reader reader{packet};
  const auto type = read_head(reader, packet.size());
  if (!type) return std::unexpected(type.error());
  switch (*type) {
    case PacketType::Command:
      return decode_answer(reader);
    case PacketType::Error:
      return decode_flat<ErrorReport>(reader);
    case PacketType::SingleMeasResult:
      return decode_flat<SingleMeasResult>(reader);
    case PacketType::MultiMeasResult:
      return decode_multi(reader);
    case PacketType::NivelResult:
      return decode_flat<NivelResult>(reader);
    case PacketType::ReflectorPosResult:
      return decode_flat<ReflectorPosResult>(reader);
    case PacketType::SystemStatusChange:
      return decode_flat<SystemStatusChange>(reader);
    case PacketType::SingleMeasResult2:
      return decode_flat<SingleMeasResult2>(reader);
  }
  return Unknown{std::to_underlying(*type)};
}

std::expected<ClientPacket, EmsconError> decode_client_packet(std::span<const std::uint8_t> packet) {
  Reader reader{packet};
  const auto type = read_head(reader, packet.size());
  if (!type) return std::unexpected(type.error());
  if (*type != PacketType::Command) return Unknown{std::to_underlying(*type)};
  Command command;
  reader(command.code);
  if (!reader.ok()) return std::unexpected(*check_end(reader));
  const auto bodies = bodies_of(command.code);
  if (!bodies) return command;
  command.body = bodies->command;
  read_body(reader, command.body);
  if (const auto error = check_end(reader)) return std::unexpected(*error);
  return command;
}

std::vector<std::uint8_t> encode(const Command& command) {
  assert(!bodies_of(command.code) || bodies_of(command.code)->command.index() == command.body.index());
  Writer writer = begin(PacketType::Command);
  writer(command.code);
  std::visit([&](const auto& body) { layout(writer, body); }, command.body);
  return std::move(writer).finish();
}

std::vector<std::uint8_t> encode(const Answer& answer) {
  assert(!bodies_of(answer.code) || bodies_of(answer.code)->answer.index() == answer.body.index() ||
         (answer.status != 0 && answer.body.index() == 0));
  Writer writer = begin(PacketType::Command);
  writer(answer.code, answer.status);
  std::visit([&](const auto& body) { layout(writer, body); }, answer.body);
  return std::move(writer).finish();
}

std::vector<std::uint8_t> encode(const ErrorReport& packet) { return encode_flat(PacketType::Error, packet); }
std::vector<std::uint8_t> encode(const SystemStatusChange& packet) {
  return encode_flat(PacketType::SystemStatusChange, packet);
}
std::vector<std::uint8_t> encode(const SingleMeasResult& packet) {
  return encode_flat(PacketType::SingleMeasResult, packet);
}
std::vector<std::uint8_t> encode(const SingleMeasResult2& packet) {
  return encode_flat(PacketType::SingleMeasResult2, packet);
}
std::vector<std::uint8_t> encode(const ReflectorPosResult& packet) {
  return encode_flat(PacketType::ReflectorPosResult, packet);
}
std::vector<std::uint8_t> encode(const NivelResult& packet) {
  return encode_flat(PacketType::NivelResult, packet);
}

std::vector<std::uint8_t> encode(const MultiMeasResult& packet) {
  Writer writer = begin(PacketType::MultiMeasResult);
  writer(packet.status, static_cast<std::int32_t>(packet.points.size()), packet.mode, packet.try_mode);
  layout(writer, packet.environment);
  for (const MultiMeasPoint& point : packet.points) layout(writer, point);
  return std::move(writer).finish();
}

}  // namespace truepose::emscon
