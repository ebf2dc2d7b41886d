#include "daemon/report/number_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/math/angles.hpp"

namespace truepose::report {
namespace {

/// Never "-0.000".
std::string fixed(double value, int decimals) {
  const double unit = std::pow(10.0, decimals);
  const double rounded = std::round(value * unit) / unit;
  return fmt::format("{:.{}f}", rounded == 0 ? 0 : rounded, decimals);
}

}  // namespace

std::string error_text(double mm) {
  return mm != 0 && std::abs(mm) < 0.0005 ? fmt::format("{:.1e}", mm) : fixed(mm, 3);
}

std::string error_text(double mm, double deviation_mm) {
  return error_text(mm) + " ± " + error_text(deviation_mm);
}

std::string length_text(double mm) { return fixed(mm, 3); }

std::string angle_text(double rad) { return fixed(rad * kDegPerRad, 4); }

std::string sigma_text(double value) {
  if (!(value > 0)) return "0";
  const int decimals = 1 - static_cast<int>(std::floor(std::log10(value)));
  if (decimals > 6) return fmt::format("{:.1e}", value);
  return fmt::format("{:.{}f}", value, decimals > 0 ? decimals : 0);
}

std::string factor_text(double before, double after) {
  if (!(after > 0)) return "-";
  const double factor = before / after;
  if (factor >= 1e6) return fmt::format("{:.0e}", factor);
  return fmt::format("{:.{}f}", factor, factor < 9.95 ? 1 : 0);
}

}  // namespace truepose::report
