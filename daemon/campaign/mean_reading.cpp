#include "daemon/campaign/mean_reading.hpp"

#include <cmath>
#include <optional>

#include "core/math/angles.hpp"

namespace truepose::daemon {

namespace {

/// Of those that have one; they differ by their noise alone.
std::optional<MeasuredOrientation> mean_orientation(std::span<const drivers::SmrPoint> readings) {
  std::optional<Eigen::Matrix3d> first;
  Eigen::Vector3d turn{0, 0, 0};
  double variance = 0;
  int count = 0;
  for (const drivers::SmrPoint& reading : readings) {
    if (!reading.orientation) continue;
    if (!first) first = reading.orientation->R_WT;
    turn += turn_between(*first, reading.orientation->R_WT);
    variance += reading.orientation->sigma_rad * reading.orientation->sigma_rad;
    ++count;
  }
  if (!first) return std::nullopt;
  return MeasuredOrientation{rotation_by(turn / count) * *first, std::sqrt(variance) / count};
}

}  // namespace

drivers::SmrPoint mean_reading(std::span<const drivers::SmrPoint> readings) {
  drivers::SmrPoint mean;
  Eigen::Array3d variances{0, 0, 0};
  for (const drivers::SmrPoint& reading : readings) {
    mean.p_WS_mm += reading.p_WS_mm;
    variances += reading.std_mm.array().square();
    mean.temperature_c += reading.temperature_c;
    mean.pressure_mbar += reading.pressure_mbar;
    mean.humidity_percent += reading.humidity_percent;
  }
  const auto n = static_cast<double>(readings.size());
  mean.p_WS_mm /= n;
  mean.std_mm = variances.sqrt() / n;
  mean.orientation = mean_orientation(readings);
  mean.temperature_c /= n;
  mean.pressure_mbar /= n;
  mean.humidity_percent /= n;
  return mean;
}

}  // namespace truepose::daemon
