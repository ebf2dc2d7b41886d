#include "tools/sim/tracker_settings.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/math/angles.hpp"
#include "proto/emscon/status.hpp"
#include "tools/sim/coordinates.hpp"

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
      const auto system = std::get<CoordinateSystemChoice>(command.body).system;
      const bool valid = system >= CoordinateSystem::Rhr && system <= CoordinateSystem::Scc;
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
    case CommandCode::GetStatisticMode:
      return got(statistic_);
    case CommandCode::SetRefractionParams:
      return set(refraction_, SystemEvent::RefractionChanged);
    case CommandCode::GetRefractionParams:
      return got(refraction_);
    case CommandCode::SetContinuousTimeModeParams:
      return set(continuous_time_, SystemEvent::ContinuousTimeParamsChanged);
    case CommandCode::GetContinuousTimeModeParams:
      return got(continuous_time_);
    case CommandCode::SetContinuousDistanceModeParams:
      return set(continuous_distance_, SystemEvent::ContinuousDistanceParamsChanged);
    case CommandCode::GetContinuousDistanceModeParams:
      return got(continuous_distance_);
    case CommandCode::SetAdmParams:
      return set(adm_, SystemEvent::AdmParamsChanged);
    case CommandCode::GetAdmParams:
      return got(adm_);
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
      return handle_parameter(command);
  }
}

/// Parameters that nobody has set are zero.
std::optional<TrackerSettings::Packets> TrackerSettings::handle_parameter(const Command& command) {
  const auto answer = [&](Body body) {
    return Packets{Answer{command.code, status::kAllOk, std::move(body)}};
  };
  if (const auto* set = std::get_if<LongParameter>(&command.body)) {
    long_parameters_[set->id] = set->value;
    return answer({});
  }
  if (const auto* set = std::get_if<DoubleParameter>(&command.body)) {
    double_parameters_[set->id] = set->value;
    return answer({});
  }
  const auto* get = std::get_if<ParameterId>(&command.body);
  if (!get) return std::nullopt;
  if (command.code == CommandCode::GetLongSystemParameter)
    return answer(LongParameter{get->id, long_parameter(get->id)});
  return answer(DoubleParameter{get->id, double_parameters_[get->id]});
}

std::int32_t TrackerSettings::long_parameter(std::int32_t id) const {
  const auto found = long_parameters_.find(id);
  return found == long_parameters_.end() ? 0 : found->second;
}

TrackerSettings::Packets TrackerSettings::reflectors() const {
  Packets answers;
  for (const Ball& ball : kReflectors) {
    const auto id = static_cast<std::int32_t>(answers.size() + 1);
    const double offset = ball.radius_mm / at(kMmPerUnit, units_.length);
    const ReflectorEntry entry{static_cast<std::int32_t>(kReflectors.size()), id, TargetKind::CornerCube,
                               offset, ball.name};
    answers.push_back(Answer{CommandCode::GetReflectors, status::kAllOk, entry});
  }
  return answers;
}

double TrackerSettings::search_radius_mm() const { return length_to_mm(search_.radius); }

std::array<double, 3> TrackerSettings::point(const Eigen::Vector3d& p_mm) const {
  return in_units(in_system(coordinates_.system, p_mm));
}

std::array<double, 3> TrackerSettings::deviations(const Eigen::Vector3d& p_mm,
                                                  const Eigen::Vector3d& std_mm) const {
  return in_units(std_in_system(coordinates_.system, p_mm, std_mm));
}

std::array<double, 3> TrackerSettings::in_units(const Eigen::Vector3d& values) const {
  std::array<double, 3> v{};
  for (Eigen::Index i = 0; i < 3; ++i) {
    v[static_cast<std::size_t>(i)] =
        is_angle(coordinates_.system, i) ? from_rad(values[i]) : from_mm(values[i]);
  }
  return v;
}

Eigen::Vector3d TrackerSettings::to_mm(const std::array<double, 3>& v) const {
  Eigen::Vector3d values;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double value = v[static_cast<std::size_t>(i)];
    values[i] = is_angle(coordinates_.system, i) ? to_rad(value) : length_to_mm(value);
  }
  return out_of_system(coordinates_.system, values);
}

Eigen::Vector3d TrackerSettings::hvd_to_mm(const std::array<double, 3>& hvd) const {
  const bool clockwise =
      coordinates_.system == CoordinateSystem::Scw || coordinates_.system == CoordinateSystem::Ccw;
  return out_of_system(clockwise ? CoordinateSystem::Scw : CoordinateSystem::Scc,
                       {to_rad(hvd[0]), to_rad(hvd[1]), length_to_mm(hvd[2])});
}

double TrackerSettings::from_mm(double length_mm) const { return length_mm / at(kMmPerUnit, units_.length); }
double TrackerSettings::length_to_mm(double length) const { return length * at(kMmPerUnit, units_.length); }
double TrackerSettings::from_rad(double angle_rad) const {
  return angle_rad * at(kUnitsPerRad, units_.angle);
}
double TrackerSettings::to_rad(double angle) const { return angle / at(kUnitsPerRad, units_.angle); }

Environment TrackerSettings::from_metric(double temperature_c, double pressure_mbar,
                                         double humidity_percent) const {
  const bool fahrenheit = units_.temperature == TemperatureUnit::Fahrenheit;
  return {fahrenheit ? temperature_c * 1.8 + 32 : temperature_c,
          pressure_mbar * at(kUnitsPerMbar, units_.pressure), humidity_percent};
}

}  // namespace truepose::sim
