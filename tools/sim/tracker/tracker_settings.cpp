#include "tools/sim/tracker/tracker_settings.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "core/math/angles.hpp"
#include "proto/emscon/status.hpp"
#include "tools/sim/tracker/tracker_beam.hpp"

namespace truepose::sim {

using namespace emscon;

namespace {

bool is_spherical(CoordinateSystem system) {
  return system == CoordinateSystem::Scw || system == CoordinateSystem::Scc;
}
bool is_cylindrical(CoordinateSystem system) {
  return system == CoordinateSystem::Ccw || system == CoordinateSystem::Ccc;
}

/// +1 where the horizontal angle runs counter-clockwise.
double turn(CoordinateSystem system) {
  return system == CoordinateSystem::Ccw || system == CoordinateSystem::Scw ? -1 : 1;
}

Eigen::Vector3d axis_signs(CoordinateSystem system) {
  return {system == CoordinateSystem::LhrX ? -1.0 : 1.0, system == CoordinateSystem::LhrY ? -1.0 : 1.0,
          system == CoordinateSystem::LhrZ ? -1.0 : 1.0};
}

/// Partial derivatives of the values by x, y and z.
Eigen::Matrix3d derivatives(CoordinateSystem system, const Eigen::Vector3d& p_mm) {
  if (!is_spherical(system) && !is_cylindrical(system)) return axis_signs(system).asDiagonal();
  const double across = std::hypot(p_mm.x(), p_mm.y()), distance = p_mm.norm();
  const Eigen::RowVector3d horizontal =
      turn(system) / (across * across) * Eigen::RowVector3d{-p_mm.y(), p_mm.x(), 0};
  const Eigen::RowVector3d outwards{p_mm.x() / across, p_mm.y() / across, 0};
  Eigen::Matrix3d by_p;
  if (is_cylindrical(system)) {
    by_p << horizontal, outwards, Eigen::RowVector3d::UnitZ();
  } else {
    by_p << horizontal, (p_mm.z() * outwards - across * Eigen::RowVector3d::UnitZ()) / (distance * distance),
        p_mm.transpose() / distance;
  }
  return by_p;
}

Eigen::Vector3d std_in_system(CoordinateSystem system, const Eigen::Vector3d& p_mm,
                              const Eigen::Vector3d& std_mm) {
  const Eigen::Vector3d variances = derivatives(system, p_mm).cwiseAbs2() * std_mm.cwiseAbs2();
  return variances.cwiseSqrt();
}

bool is_angle(CoordinateSystem system, Eigen::Index index) {
  return (index == 0 && (is_spherical(system) || is_cylindrical(system))) ||
         (index == 1 && is_spherical(system));
}

constexpr std::array kMmPerUnit{1000.0, 1.0, 0.001, 304.8, 914.4, 25.4};
constexpr std::array kUnitsPerRad{1.0, kDegPerRad, 200 / std::numbers::pi};
constexpr std::array kUnitsPerMbar{1.0, 1.0, 0.1, 0.75006158, 0.014503774, 0.40146308, 0.029529983};

constexpr std::int32_t kOutOfRange = 12;  ///< parameter 1 out of range, refused

/// Ids from 1.
constexpr const auto& kReflectors = kReflectorBalls;

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

Eigen::Vector3d in_system(CoordinateSystem system, const Eigen::Vector3d& p_mm) {
  const double horizontal = turn(system) * std::atan2(p_mm.y(), p_mm.x());
  const double across = std::hypot(p_mm.x(), p_mm.y());
  if (is_cylindrical(system)) return {horizontal, across, p_mm.z()};
  if (is_spherical(system)) return {horizontal, std::atan2(across, p_mm.z()), p_mm.norm()};
  return axis_signs(system).cwiseProduct(p_mm);
}

Eigen::Vector3d out_of_system(CoordinateSystem system, const Eigen::Vector3d& values) {
  const double horizontal = turn(system) * values[0];
  const Eigen::Vector3d outwards{std::cos(horizontal), std::sin(horizontal), 0};
  if (is_cylindrical(system)) return values[1] * outwards + values[2] * Eigen::Vector3d::UnitZ();
  if (is_spherical(system))
    return values[2] * (std::sin(values[1]) * outwards + std::cos(values[1]) * Eigen::Vector3d::UnitZ());
  return axis_signs(system).cwiseProduct(values);
}

std::optional<std::vector<TrackerPacket>> TrackerSettings::handle(const Command& command) {
  if (command.code == CommandCode::GetReflectors) return reflectors();
  std::optional<Packets> packets;
  const auto setting = [&]<class T>(CommandCode set, CommandCode get, T& stored, SystemEvent event,
                                    std::type_identity_t<bool (*)(const T&)> is_valid = nullptr) {
    if (command.code == get) packets = {Answer{command.code, status::kAllOk, stored}};
    if (command.code != set) return;
    const T& wanted = std::get<T>(command.body);
    if (is_valid && !is_valid(wanted)) {
      packets = {Answer{command.code, kOutOfRange, {}}};
      return;
    }
    stored = wanted;
    packets = {Answer{command.code, status::kAllOk, {}}, SystemStatusChange{event}};
  };
  using enum CommandCode;
  setting(SetUnits, GetUnits, units_, SystemEvent::UnitsChanged, [](const Units& units) {
    return is_one_of(kMmPerUnit, units.length) && is_one_of(kUnitsPerRad, units.angle) &&
           is_one_of(kUnitsPerMbar, units.pressure);
  });
  setting(SetCoordinateSystemType, GetCoordinateSystemType, coordinates_,
          SystemEvent::CoordinateSystemChanged, [](const CoordinateSystemChoice& choice) {
            return choice.system >= CoordinateSystem::Rhr && choice.system <= CoordinateSystem::Scc;
          });
  setting(SetMeasurementMode, GetMeasurementMode, mode_, SystemEvent::MeasurementModeChanged,
          [](const MeasurementModeChoice& choice) { return choice.mode == MeasurementMode::Stationary; });
  setting(SetStationaryModeParams, GetStationaryModeParams, stationary_, SystemEvent::StationaryParamsChanged,
          [](const StationaryModeParams& params) { return params.measure_ms > 0; });
  setting(SetSearchParams, GetSearchParams, search_, SystemEvent::SearchParamsChanged,
          [](const SearchParams& params) { return params.radius > 0; });
  setting(SetReflector, GetReflector, reflector_, SystemEvent::ReflectorChanged,
          [](const ReflectorChoice& choice) {
            return choice.id >= 1 && choice.id <= static_cast<int>(kReflectors.size());
          });
  setting(SetSystemSettings, GetSystemSettings, system_, SystemEvent::SystemSettingsChanged);
  setting(SetTransformationParams, GetTransformationParams, transformation_,
          SystemEvent::TransformationChanged);
  setting(SetStationOrientationParams, GetStationOrientationParams, orientation_,
          SystemEvent::StationOrientationChanged);
  setting(SetEnvironmentParams, GetEnvironmentParams, environment_, SystemEvent::EnvironmentChanged);
  setting(SetStatisticMode, GetStatisticMode, statistic_, SystemEvent::StatisticModeChanged);
  setting(SetRefractionParams, GetRefractionParams, refraction_, SystemEvent::RefractionChanged);
  setting(SetContinuousTimeModeParams, GetContinuousTimeModeParams, continuous_time_,
          SystemEvent::ContinuousTimeParamsChanged);
  setting(SetContinuousDistanceModeParams, GetContinuousDistanceModeParams, continuous_distance_,
          SystemEvent::ContinuousDistanceParamsChanged);
  setting(SetAdmParams, GetAdmParams, adm_, SystemEvent::AdmParamsChanged);
  return packets ? packets : handle_parameter(command);
}

/// Parameters that were never set are zero.
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
  for (const ReflectorBall& ball : kReflectors) {
    const auto id = static_cast<std::int32_t>(answers.size() + 1);
    const double offset = ball.radius_mm / at(kMmPerUnit, units_.length);
    const ReflectorEntry entry{static_cast<std::int32_t>(kReflectors.size()), id, TargetKind::CornerCube,
                               offset, std::string{ball.name}};
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

Environment TrackerSettings::from_metric(const Air& air) const {
  const bool fahrenheit = units_.temperature == TemperatureUnit::Fahrenheit;
  return {fahrenheit ? air.temperature_c * 1.8 + 32 : air.temperature_c,
          air.pressure_mbar * at(kUnitsPerMbar, units_.pressure), air.humidity_percent};
}

}  // namespace truepose::sim
