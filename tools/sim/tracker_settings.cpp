#include "tools/sim/tracker_settings.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "core/kinematics/angles.hpp"
#include "proto/emscon/status.hpp"

namespace truepose::sim {

using namespace emscon;

namespace {

constexpr std::array kMmPerUnit{1000.0, 1.0, 0.001, 304.8, 914.4, 25.4};
constexpr std::array kUnitsPerRad{1.0, kDegPerRad, 200 / std::numbers::pi};
constexpr std::array kUnitsPerMbar{1.0, 1.0, 0.1, 0.75006158, 0.014503774, 0.40146308, 0.029529983};

constexpr std::int32_t kOutOfRange = 12;  ///< parameter 1 out of range, refused

struct Ball {
  const char* name;
  double radius_mm;
};
constexpr std::array kReflectors{Ball{"CCR-1.5in", 19.05}, Ball{"CCR-0.5in", 6.35}};  // ids 1 and 2

template <std::size_t N>
bool is_one_of(const std::array<double, N>&, auto value) {
  const auto number = static_cast<std::int32_t>(value);
  return number >= 0 && number < static_cast<std::int32_t>(N);
}

template <std::size_t N>
double at(const std::array<double, N>& factors, auto value) {
  return factors.at(static_cast<std::size_t>(value));
}

}  // namespace

std::optional<std::vector<TrackerPacket>> TrackerSettings::handle(const Command& command) {
  using Packets = std::vector<TrackerPacket>;
  const auto got = [&](const auto& value) { return Packets{Answer{command.code, status::kAllOk, value}}; };
  const auto set = [&]<class T>(T& stored, SystemEvent event, bool valid = true) {
    if (!valid) return Packets{Answer{command.code, kOutOfRange, {}}};
    stored = std::get<T>(command.body);
    return Packets{Answer{command.code, status::kAllOk, {}}, SystemStatusChange{event}};
  };
  switch (command.code) {
    case CommandCode::SetUnits: {
      const Units& units = std::get<Units>(command.body);
      const bool valid = is_one_of(kMmPerUnit, units.length) && is_one_of(kUnitsPerRad, units.angle) &&
                         is_one_of(kUnitsPerMbar, units.pressure);
      return set(units_, SystemEvent::UnitsChanged, valid);
    }
    case CommandCode::GetUnits:
      return got(units_);
    case CommandCode::SetCoordinateSystemType: {
      const bool valid = std::get<CoordinateSystemChoice>(command.body).system == CoordinateSystem::Rhr;
      return set(coordinates_, SystemEvent::CoordinateSystemChanged, valid);
    }
    case CommandCode::GetCoordinateSystemType:
      return got(coordinates_);
    case CommandCode::SetMeasurementMode: {
      const bool valid = std::get<MeasurementModeChoice>(command.body).mode == MeasurementMode::Stationary;
      return set(mode_, SystemEvent::MeasurementModeChanged, valid);
    }
    case CommandCode::GetMeasurementMode:
      return got(mode_);
    case CommandCode::SetStationaryModeParams: {
      const bool valid = std::get<StationaryModeParams>(command.body).measure_ms > 0;
      return set(stationary_, SystemEvent::StationaryParamsChanged, valid);
    }
    case CommandCode::GetStationaryModeParams:
      return got(stationary_);
    case CommandCode::SetSearchParams: {
      const bool valid = std::get<SearchParams>(command.body).radius > 0;
      return set(search_, SystemEvent::SearchParamsChanged, valid);
    }
    case CommandCode::GetSearchParams:
      return got(search_);
    case CommandCode::SetSystemSettings:
      return set(system_, SystemEvent::SystemSettingsChanged);
    case CommandCode::GetSystemSettings:
      return got(system_);
    case CommandCode::SetTransformationParams:
      return set(transformation_, SystemEvent::TransformationChanged);
    case CommandCode::GetTransformationParams:
      return got(transformation_);
    case CommandCode::SetStationOrientationParams:
      return set(orientation_, SystemEvent::StationOrientationChanged);
    case CommandCode::GetStationOrientationParams:
      return got(orientation_);
    case CommandCode::SetEnvironmentParams:
      return set(environment_, SystemEvent::EnvironmentChanged);
    case CommandCode::GetEnvironmentParams:
      return got(environment_);
    case CommandCode::SetStatisticMode:
      return set(statistic_, SystemEvent::StatisticModeChanged);
    case CommandCode::SetReflector: {
      const std::int32_t id = std::get<ReflectorChoice>(command.body).id;
      return set(reflector_, SystemEvent::ReflectorChanged,
                 id >= 1 && id <= static_cast<int>(kReflectors.size()));
    }
    case CommandCode::GetReflector:
      return got(reflector_);
    case CommandCode::GetReflectors:
      return reflectors();
    default:
      return std::nullopt;
  }
}

std::vector<TrackerPacket> TrackerSettings::reflectors() const {
  std::vector<TrackerPacket> answers;
  for (const Ball& ball : kReflectors) {
    const auto id = static_cast<std::int32_t>(answers.size() + 1);
    const double offset = ball.radius_mm / at(kMmPerUnit, units_.length);
    const ReflectorEntry entry{static_cast<std::int32_t>(kReflectors.size()), id, TargetKind::CornerCube,
                               offset, ball.name};
    answers.push_back(Answer{CommandCode::GetReflectors, status::kAllOk, entry});
  }
  return answers;
}

double TrackerSettings::search_radius_mm() const { return search_.radius * at(kMmPerUnit, units_.length); }

std::array<double, 3> TrackerSettings::from_mm(const Eigen::Vector3d& v_mm) const {
  const Eigen::Vector3d v = v_mm / at(kMmPerUnit, units_.length);
  return {v.x(), v.y(), v.z()};
}

Eigen::Vector3d TrackerSettings::to_mm(const std::array<double, 3>& v) const {
  return Eigen::Vector3d{v[0], v[1], v[2]} * at(kMmPerUnit, units_.length);
}

double TrackerSettings::from_rad(double angle_rad) const {
  return angle_rad * at(kUnitsPerRad, units_.angle);
}

Environment TrackerSettings::from_metric(double temperature_c, double pressure_mbar,
                                         double humidity_percent) const {
  const bool fahrenheit = units_.temperature == TemperatureUnit::Fahrenheit;
  return {fahrenheit ? temperature_c * 1.8 + 32 : temperature_c,
          pressure_mbar * at(kUnitsPerMbar, units_.pressure), humidity_percent};
}

}  // namespace truepose::sim
