#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/math/refraction.hpp"
#include "proto/emscon/enums.hpp"
#include "proto/emscon/packets.hpp"

namespace truepose::sim {

/// The three values of a point in one of the tracker's coordinate systems: mm and rad.
///
/// Left-handed systems have one axis reversed. Angles run clockwise or counter-clockwise seen from above.
/// Spherical values are the horizontal angle, the angle from the zenith and the distance, as a public client
/// prints them; the order of the cylindrical ones (angle, distance from the axis, height) is not public, and
/// invented.
Eigen::Vector3d in_system(emscon::CoordinateSystem system, const Eigen::Vector3d& p_mm);
/// The other way, to right-handed Cartesian mm.
Eigen::Vector3d out_of_system(emscon::CoordinateSystem system, const Eigen::Vector3d& values);

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
  /// Whether it finds the refraction of the air by its weather station.
  bool computes_refraction() const { return system_.weather == emscon::WeatherMonitor::ReadAndCompute; }
  double adm_index() const { return refraction_.adm_index; }
  const emscon::Environment& environment() const { return environment_; }
  bool sends_reflector_position() const { return system_.send_reflector_position; }

  bool power_lock() const { return long_parameter(kPowerLockActive) != 0; }

  /// A point in the units and the coordinate system that were chosen, and its standard deviations.
  std::array<double, 3> point(const Eigen::Vector3d& p_mm) const;
  std::array<double, 3> deviations(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& std_mm) const;
  Eigen::Vector3d to_mm(const std::array<double, 3>& v) const;
  /// The same from horizontal angle, vertical angle and distance, whatever the coordinate system.
  Eigen::Vector3d hvd_to_mm(const std::array<double, 3>& hvd) const;
  double from_mm(double length_mm) const;
  double length_to_mm(double length) const;
  double from_rad(double angle_rad) const;
  double to_rad(double angle) const;
  emscon::Environment from_metric(const Air& air) const;

 private:
  // A system parameter.
  static constexpr std::int32_t kPowerLockActive = 411;

  using Packets = std::vector<emscon::TrackerPacket>;

  /// The reflectors that it knows, one answer each.
  Packets reflectors() const;
  std::optional<Packets> handle_parameter(const emscon::Command& command);
  std::int32_t long_parameter(std::int32_t id) const;
  std::array<double, 3> in_units(const Eigen::Vector3d& values) const;

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
  emscon::Refraction refraction_{1.000271296, 1.000268286};  // of air at 20 deg C
  emscon::ContinuousTimeParams continuous_time_{20};
  emscon::ContinuousDistanceParams continuous_distance_{0.01};
  emscon::AdmParams adm_{0.0001, 500, 3};
  std::map<std::int32_t, std::int32_t> long_parameters_;
  std::map<std::int32_t, double> double_parameters_;
};

}  // namespace truepose::sim
