#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "proto/emscon/packets.hpp"

namespace truepose::sim {

/// What a client can write into a simulated tracker and read back. Starts as a tracker comes: metres, nothing
/// switched on.
class TrackerSettings {
 public:
  /// Packets that answer a command which only writes or reads a setting: the answer, then the event of a
  /// change. Nothing for other commands.
  std::optional<std::vector<emscon::TrackerPacket>> handle(const emscon::Command& command);

  double measure_ms() const { return stationary_.measure_ms; }
  double search_radius_mm() const;
  double search_timeout_ms() const { return search_.timeout_ms; }
  bool extended_statistics() const { return statistic_.stationary == emscon::StatisticKind::Extended; }
  bool sends_reflector_position() const { return system_.send_reflector_position; }

  std::array<double, 3> from_mm(const Eigen::Vector3d& v_mm) const;
  Eigen::Vector3d to_mm(const std::array<double, 3>& v) const;
  double from_rad(double angle_rad) const;
  emscon::Environment from_metric(double temperature_c, double pressure_mbar, double humidity_percent) const;

 private:
  /// The reflectors that it knows, one answer each.
  std::vector<emscon::TrackerPacket> reflectors() const;

  emscon::Units units_;
  emscon::CoordinateSystemChoice coordinates_;
  emscon::MeasurementModeChoice mode_;
  emscon::StationaryModeParams stationary_{2000, true};
  emscon::SearchParams search_{0.05, 10000};
  emscon::SystemSettings system_{.weather = emscon::WeatherMonitor::ReadAndCompute};
  emscon::Transformation transformation_;
  emscon::StationOrientation orientation_;
  emscon::Environment environment_{20, 1013.25, 50};
  emscon::StatisticMode statistic_;
  emscon::ReflectorChoice reflector_{2};
};

}  // namespace truepose::sim
