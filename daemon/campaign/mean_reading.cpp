#include "daemon/campaign/mean_reading.hpp"

namespace truepose::daemon {

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
  mean.temperature_c /= n;
  mean.pressure_mbar /= n;
  mean.humidity_percent /= n;
  return mean;
}

}  // namespace truepose::daemon
