#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "proto/emscon/packets.hpp"

namespace truepose::emscon {

/// A packet's bytes, made by a C program compiled against the maker's struct layouts, and its meaning.
struct Golden {
  std::string_view name;
  std::string_view hex;
  std::variant<ClientPacket, TrackerPacket> packet;
};

inline std::vector<Golden> golden_packets() {
  const SingleMeasResult single{.v = {1000, 2000, -500},
                                .std = {.005, .006, .007},
                                .std_total = .0105,
                                .apriori_std = {.010, .011, .012},
                                .apriori_total = .0191,
                                .environment = {20, 1013.25, 50}};
  const MultiMeasResult multi{
      .mode = MeasurementMode::ContinuousTime,
      .environment = {20, 1013.25, 50},
      .points = {{0, 12, 500000, {1000, 2000, -500}}, {0, 12, 520000, {1000, 2000, -499}}}};
  const SystemStatus system{.processor = ProcessorStatus::Initialized,
                            .laser = LaserStatus::Ready,
                            .adm = AdmStatus::Ready,
                            .server_version = {3, 8, 900},
                            .weather = WeatherMonitor::ReadOnly,
                            .serial_number = 390793};
  const Units mm{.length = LengthUnit::Millimeter};
  const auto command = [](CommandCode code, Body body = {}) {
    return ClientPacket{Command{code, std::move(body)}};
  };
  const auto answer = [](CommandCode code, std::int32_t status, Body body = {}) {
    return TrackerPacket{Answer{code, status, std::move(body)}};
  };
  using enum CommandCode;
  return {
      {"Initialize", "0c000000 00000000 07000000", command(Initialize)},
      {"Initialize answer", "10000000 00000000 07000000 00000000", answer(Initialize, 0)},
      {"GetSystemStatus answer",
       "38000000 00000000 01000000 00000000 00000000 05000000 03000000 02000000 03000000 08000000 84030000 "
       "01000000 "
       "00000000 89f60500",
       answer(GetSystemStatus, 0, system)},
      {"SetUnits", "20000000 00000000 05000000 01000000 00000000 00000000 00000000 00000000",
       command(SetUnits, mm)},
      {"SetMeasurementMode", "10000000 00000000 18000000 00000000",
       command(SetMeasurementMode, MeasurementModeChoice{})},
      {"SetStationaryModeParams", "14000000 00000000 1c000000 d0070000 01000000",
       command(SetStationaryModeParams, StationaryModeParams{2000, true})},
      {"SetReflector", "10000000 00000000 28000000 07000000", command(SetReflector, ReflectorChoice{7})},
      {"SetSearchParams", "18000000 00000000 2b000000 00000000 00004940 10270000",
       command(SetSearchParams, SearchParams{50, 10000})},
      {"FindReflector", "14000000 00000000 3f000000 00000000 0070a740",
       command(FindReflector, SearchDistance{3000})},
      {"GoPosition",
       "28000000 00000000 37000000 00000000 00408f40 00000000 00409f40 00000000 00407fc0 01000000",
       command(GoPosition, Position{{1000, 2000, -500}, true})},
      {"GetReflectors answer",
       "64000000 00000000 2a000000 00000000 02000000 01000000 01000000 00000000 00000000 43004300 52002d00 "
       "31002e00 "
       "35006900 6e000000 00000000 00000000 00000000 00000000 00000000 00000000 00000000 00000000 00000000 "
       "00000000 "
       "00000000",
       answer(GetReflectors, 0, ReflectorEntry{2, 1, TargetKind::CornerCube, 0, "CCR-1.5in"})},
      {"StartMeasurement", "0c000000 00000000 31000000", command(StartMeasurement)},
      {"StartMeasurement answer", "10000000 00000000 31000000 00000000", answer(StartMeasurement, 0)},
      {"StartMeasurement busy", "10000000 00000000 31000000 01000000", answer(StartMeasurement, 1)},
      {"StartMeasurement not initialised", "10000000 00000000 31000000 27000000",
       answer(StartMeasurement, 39)},
      {"StartMeasurement not ready", "10000000 00000000 31000000 1e270000", answer(StartMeasurement, 10014)},
      {"SingleMeasResult",
       "9c000000 02000000 00000000 00000000 00000000 00000000 00408f40 00000000 00409f40 00000000 00407fc0 "
       "7b14ae47 "
       "e17a743f fa7e6abc 7493783f 79e92631 08ac7c3f 1b2fdd24 0681853f 00000000 00000000 00000000 00000000 "
       "00000000 "
       "00000000 7b14ae47 e17a843f ba490c02 2b87863f fa7e6abc 7493883f 1e166a4d f38e933f 00000000 00003440 "
       "00000000 "
       "00aa8f40 00000000 00004940",
       TrackerPacket{single}},
      {"ReflectorPosResult",
       "24000000 07000000 00000000 00000000 00408f40 00000000 00409f40 00000000 00407fc0",
       TrackerPacket{ReflectorPosResult{0, {1000, 2000, -500}}}},
      {"MultiMeasResult",
       "78000000 03000000 00000000 02000000 01000000 00000000 00000000 00003440 00000000 00aa8f40 00000000 "
       "00004940 "
       "00000000 0c000000 20a10700 00000000 00408f40 00000000 00409f40 00000000 00407fc0 "
       "00000000 0c000000 40ef0700 00000000 00408f40 00000000 00409f40 00000000 00307fc0",
       TrackerPacket{multi}},
      {"Error of StartMeasurement", "10000000 01000000 31000000 19270000",
       TrackerPacket{ErrorReport{StartMeasurement, 10009}}},
      {"Error without a command", "10000000 01000000 40000000 23000000",
       TrackerPacket{ErrorReport{CommandCode::Unknown, 35}}},
      {"ready", "0c000000 08000000 1b000000",
       TrackerPacket{SystemStatusChange{SystemEvent::MeasurementReady}}},
      {"not ready", "0c000000 08000000 19000000",
       TrackerPacket{SystemStatusChange{SystemEvent::MeasurementNotReady}}},
      {"server closing", "0c000000 08000000 e6030000",
       TrackerPacket{SystemStatusChange{SystemEvent::ServerClosing}}},
  };
}

inline std::vector<std::uint8_t> bytes_of(std::string_view hex) {
  std::vector<std::uint8_t> bytes;
  unsigned digits = 0, value = 0;
  for (const char c : hex) {
    if (c == ' ') continue;
    value = value << 4 | static_cast<unsigned>(c <= '9' ? c - '0' : c - 'a' + 10);
    if (++digits % 2 == 0) bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  }
  return bytes;
}

inline std::vector<std::uint8_t> encode_any(const std::variant<ClientPacket, TrackerPacket>& packet) {
  return std::visit(
      [](const auto& side) {
        return std::visit(
            []<class T>(const T& alternative) {
              if constexpr (std::same_as<T, Unknown>)
                return std::vector<std::uint8_t>{};
              else
                return encode(alternative);
            },
            side);
      },
      packet);
}

}  // namespace truepose::emscon
