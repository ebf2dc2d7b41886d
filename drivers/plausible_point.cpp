#include "drivers/plausible_point.hpp"

#include <array>

#include "core/formatted.hpp"
#include "core/math/units.hpp"

namespace truepose::drivers {

namespace {

struct Plausible {
  double value, min, max;
  const char* what;
  const char* unit;
  const char* remedy;
};

constexpr const char* kWeather = "check its weather station, or the weather that was entered";
constexpr const char* kSpread = "measure again; if it stays, restart the tracker";

std::optional<std::string> implausible(const MeasuredOrientation& orientation) {
  constexpr double kLargest_deg = 5;  // no 6-D target is worse than 0.1 deg
  const double sigma_deg = orientation.sigma_rad * kDegPerRad;
  if (sigma_deg > 0 && sigma_deg <= kLargest_deg) return std::nullopt;
  return formatted(
      "the tracker gives the target's orientation a standard deviation of %.6g deg, plausible are more than 0 "
      "and at most %g deg: check the bridge",
      sigma_deg, kLargest_deg);
}

}  // namespace

std::optional<std::string> implausible(const SmrPoint& point) {
  const std::array<Plausible, 6> numbers{
      {{point.temperature_c, -20, 60, "an air temperature", "C", kWeather},
       {point.pressure_mbar, 500, 1100, "an air pressure", "mbar", kWeather},
       {point.humidity_percent, 0, 100, "a humidity", "%", kWeather},
       {point.std_mm.x(), 0, 100, "a spread of its readings along x", "mm", kSpread},
       {point.std_mm.y(), 0, 100, "a spread of its readings along y", "mm", kSpread},
       {point.std_mm.z(), 0, 100, "a spread of its readings along z", "mm", kSpread}}};
  for (const Plausible& number : numbers) {
    // Written so that a NaN is refused as well.
    if (number.value >= number.min && number.value <= number.max) continue;
    return formatted("the tracker says %s of %.6g %s, plausible are %g..%g %s: %s", number.what, number.value,
                     number.unit, number.min, number.max, number.unit, number.remedy);
  }
  if (point.std_mm.isZero(0))
    return "the tracker says a spread of its readings of exactly 0 mm, which no tracker has: " +
           std::string(kSpread);
  if (point.orientation) return implausible(*point.orientation);
  return std::nullopt;
}

}  // namespace truepose::drivers
