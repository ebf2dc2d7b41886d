#include "drivers/plausible_point.hpp"

#include <array>

#include "core/formatted.hpp"

namespace truepose::drivers {

namespace {

struct Plausible {
  double value, min, max;
  const char* what;
  const char* unit;
  const char* remedy;
};

constexpr const char* kWeather = "check its weather station, or the weather that was entered";
constexpr const char* kSpread = "measure again; if it stays, start the tracker anew";

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
  return std::nullopt;
}

}  // namespace truepose::drivers
