#include "drivers/leica/emscon_settings.hpp"

#include <cmath>
#include <span>
#include <utility>

namespace truepose::drivers {

using namespace emscon;

const Units kEmsconUnits{LengthUnit::Millimeter, AngleUnit::Radian, TemperatureUnit::Celsius,
                         PressureUnit::Mbar, HumidityUnit::RelativePercent};

namespace {

// Of the interferometer, and of the distance meter of an AT40x; one of 780 nm would differ by 0.3 um/m.
constexpr double kIfm_um = 0.633, kAdm_um = 0.795;

/// AT40x ignore an index until its sixth decimal changes, so that this one, of no air there is, goes before.
constexpr Refraction kFarRefraction{1.00015, 1.00015};

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

/// What a tracker may report otherwise than it was written: ignored by some models, a fact of the hardware,
/// or rounded.
Body without_hardware_facts(Body body) {
  if (auto* params = std::get_if<StationaryModeParams>(&body)) params->use_adm = true;
  if (auto* settings = std::get_if<SystemSettings>(&body)) {
    settings->try_mode = 0;
    settings->has_nivel = false;
    settings->has_video_camera = false;
  }
  if (auto* air = std::get_if<Environment>(&body))
    *air = {rounded(air->temperature, 0.1), rounded(air->pressure, 0.1), rounded(air->humidity, 1)};
  if (auto* index = std::get_if<Refraction>(&body))
    *index = {rounded(index->ifm_index, 1e-7), rounded(index->adm_index, 1e-7)};
  return body;
}

bool concerns_settings(SystemEvent event) {
  switch (event) {
    case SystemEvent::UnitsChanged:
    case SystemEvent::ReflectorChanged:
    case SystemEvent::SystemSettingsChanged:
    case SystemEvent::CoordinateSystemChanged:
    case SystemEvent::StationOrientationChanged:
    case SystemEvent::TransformationChanged:
    case SystemEvent::MeasurementModeChanged:
    case SystemEvent::StationaryParamsChanged:
      return true;
    default:
      return false;
  }
}

/// A weather station raises these by itself.
bool concerns_air(SystemEvent event) {
  return event == SystemEvent::EnvironmentChanged || event == SystemEvent::RefractionChanged;
}

std::string_view name_at(std::span<const std::string_view> names, auto unit) {
  const auto index = static_cast<std::size_t>(std::to_underlying(unit));
  return index < names.size() ? names[index] : "unknown";
}

/// "mm, rad, C, mbar"
std::string named(const Units& units) {
  constexpr std::string_view kLengths[] = {"m", "mm", "um", "ft", "yd", "in"};
  constexpr std::string_view kAngles[] = {"rad", "deg", "gon"};
  constexpr std::string_view kTemperatures[] = {"C", "F"};
  constexpr std::string_view kPressures[] = {"mbar", "hPa", "kPa", "mmHg", "psi", "inH2O", "inHg"};
  std::string text{name_at(kLengths, units.length)};
  text.append(", ").append(name_at(kAngles, units.angle));
  text.append(", ").append(name_at(kTemperatures, units.temperature));
  return text.append(", ").append(name_at(kPressures, units.pressure));
}

WeatherMonitor weather_monitor(const EmsconSettings::Wanted& wanted) {
  const bool by_station = wanted.has_weather_station && !wanted.air;
  return by_station ? WeatherMonitor::ReadAndCompute : WeatherMonitor::NotConnected;
}

Environment environment_of(const Air& air) {
  return {air.temperature_c, air.pressure_mbar, air.humidity_percent};
}

Refraction refraction_of(const Air& air) { return {phase_index(air, kIfm_um), group_index(air, kAdm_um)}; }

}  // namespace

std::vector<EmsconSettings::Setting> EmsconSettings::settings_of(const Wanted& wanted) {
  using enum CommandCode;
  const SystemSettings system{
      .weather = weather_monitor(wanted), .keep_last_position = true, .send_unsolicited_messages = true};
  std::vector<Setting> settings{
      {SetUnits, GetUnits, kEmsconUnits, "units"},
      {SetCoordinateSystemType, GetCoordinateSystemType, CoordinateSystemChoice{}, "coordinate system"},
      {SetSystemSettings, GetSystemSettings, system, "system settings"},
      {SetTransformationParams, GetTransformationParams, Transformation{}, "transformation"},
      {SetStationOrientationParams, GetStationOrientationParams, StationOrientation{}, "station orientation"},
      {SetMeasurementMode, GetMeasurementMode, MeasurementModeChoice{}, "measurement mode"},
      {SetStationaryModeParams, GetStationaryModeParams, StationaryModeParams{wanted.measure_ms, true},
       "measuring time"},
      {SetReflector, GetReflector, ReflectorChoice{wanted.reflector}, "reflector"},
  };
  if (!wanted.air) return settings;
  settings.push_back({SetEnvironmentParams, GetEnvironmentParams, environment_of(*wanted.air), "air"});
  settings.push_back({SetRefractionParams, GetRefractionParams, refraction_of(*wanted.air),
                      "refraction of the air", kFarRefraction});
  return settings;
}

/// "reflector", and what is there in its place where that can be said.
std::string EmsconSettings::described(const Setting& setting, const Body& found) {
  std::string text{setting.name};
  const auto* units = std::get_if<Units>(&found);
  if (units != nullptr) text += " (it has " + named(*units) + ", needed are " + named(kEmsconUnits) + ")";
  return text;
}

void EmsconSettings::observe(SystemEvent event) {
  if (concerns_settings(event) || (wanted_.air && concerns_air(event))) in_doubt_ = true;
}

TrackerTask<void> EmsconSettings::write(Wanted wanted) {
  want(wanted);
  const auto written = co_await write_all();
  if (!written) co_return written;
  auto ensured = co_await ensure();
  co_return ensured;
}

void EmsconSettings::use_air(const Air& air) {
  if (!wanted_.air || *wanted_.air == air) return;
  Wanted wanted = wanted_;
  wanted.air = air;
  want(wanted);
}

void EmsconSettings::use_time(std::int32_t measure_ms) {
  if (wanted_.measure_ms == measure_ms) return;
  Wanted wanted = wanted_;
  wanted.measure_ms = measure_ms;
  want(wanted);
}

void EmsconSettings::want(const Wanted& wanted) {
  wanted_ = wanted;
  settings_ = settings_of(wanted_);
  in_doubt_ = true;
}

TrackerTask<void> EmsconSettings::write_all() {
  for (const Setting& setting : settings_) {
    const std::string what = "the tracker refuses its " + std::string{setting.name};
    for (const Body* body : {&setting.before, &setting.wanted}) {
      if (std::holds_alternative<std::monostate>(*body)) continue;
      Command write{setting.set, *body};
      const auto answer = co_await connection_.accepted(std::move(write), what);
      if (!answer) co_return std::unexpected(answer.error());
    }
  }
  co_return TrackerResult<void>{};
}

/// @return which setting is not as wanted, or nothing
TrackerTask<std::string> EmsconSettings::first_wrong() {
  for (const Setting& setting : settings_) {
    const std::string what = "the tracker hides its " + std::string{setting.name};
    const auto answer = co_await connection_.ask(setting.get, what);
    if (!answer) co_return std::unexpected(answer.error());
    if (without_hardware_facts(answer->body) != without_hardware_facts(setting.wanted))
      co_return described(setting, answer->body);
  }
  co_return std::string{};
}

// Reading first, because every write raises events that look like those of another program's write.
TrackerTask<void> EmsconSettings::ensure() {
  std::string wrong;
  for (int attempt = 0; in_doubt_ && attempt < 3; ++attempt) {
    in_doubt_ = false;
    const auto checked = co_await first_wrong();
    if (!checked) in_doubt_ = true;
    if (!checked) co_return std::unexpected(checked.error());
    wrong = *checked;
    if (wrong.empty()) continue;
    const auto written = co_await write_all();
    in_doubt_ = true;
    if (!written) co_return std::unexpected(written.error());
  }
  if (in_doubt_) {
    const std::string name = wrong.empty() ? "settings" : wrong;
    co_return std::unexpected(
        TrackerError{TrackerFault::NotReady,
                     "the tracker does not keep its " + name + ": does another program change them?"});
  }
  co_return TrackerResult<void>{};
}

}  // namespace truepose::drivers
