#include "core/simulate/tracker_instrument.hpp"

#include <cmath>

#include "core/math/angles.hpp"

namespace truepose {
namespace {

double saturated_vapour_Pa(double t_c) {  // Buck 1996
  return 611.21 * std::exp((18.678 - t_c / 234.5) * t_c / (257.14 + t_c));
}

double edlen_phase_index(const Air& air, double wavelength_um) {
  const double t = air.temperature_c, p_Pa = 100 * air.pressure_mbar;
  const double s2 = 1 / (wavelength_um * wavelength_um);
  const double standard = 1e-8 * (8342.54 + 2406147 / (130 - s2) + 15998 / (38.9 - s2));
  const double denser = (1 + 1e-8 * (0.601 - 0.00972 * t) * p_Pa) / (1 + 0.003661 * t);
  const double vapour_Pa = air.humidity_percent / 100 * saturated_vapour_Pa(t);
  return 1 + p_Pa * standard * denser / 96095.43 -
         1e-10 * 292.75 / (t + 273.15) * (3.7345 - 0.0401 * s2) * vapour_Pa;
}

/// The point at this distance, horizontal angle and angle from the zenith.
Eigen::Vector3d polar(double distance_mm, double horizontal, double vertical) {
  return distance_mm * Eigen::Vector3d{std::sin(vertical) * std::cos(horizontal),
                                       std::sin(vertical) * std::sin(horizontal), std::cos(vertical)};
}

}  // namespace

double edlen_group_index(const Air& air) {
  constexpr double kAdm_um = 0.795, kStep_um = 1e-4;
  const double slope =
      (edlen_phase_index(air, kAdm_um + kStep_um) - edlen_phase_index(air, kAdm_um - kStep_um)) /
      (2 * kStep_um);
  return edlen_phase_index(air, kAdm_um) - kAdm_um * slope;
}

Eigen::Vector3d AimingErrors::seen(const Eigen::Vector3d& p_W_mm, int face) const {
  if (*this == AimingErrors{}) return p_W_mm;
  const double sign = face == 2 ? -1 : 1;
  const double across_mm = std::hypot(p_W_mm.x(), p_W_mm.y());
  const double vertical = std::atan2(across_mm, p_W_mm.z());
  const double horizontal = std::atan2(p_W_mm.y(), p_W_mm.x()) +
                            sign * (collimation / std::sin(vertical) + tilt / std::tan(vertical));
  return polar(p_W_mm.norm(), horizontal, vertical + sign * index);
}

Eigen::Vector3d TrackerWarming::seen(const Eigen::Vector3d& p_W_mm, std::chrono::duration<double> age) const {
  if (*this == TrackerWarming{}) return p_W_mm;
  const double left = std::exp(-std::chrono::duration<double, std::ratio<60>>{age}.count() / minutes);
  const double vertical = std::atan2(std::hypot(p_W_mm.x(), p_W_mm.y()), p_W_mm.z());
  const double horizontal = std::atan2(p_W_mm.y(), p_W_mm.x());
  return polar(p_W_mm.norm() + left * range_mm, horizontal + left * horizontal_rad,
               vertical + left * vertical_rad);
}

Eigen::Isometry3d TripodDrift::motion(std::chrono::duration<double> age) const {
  const double hours = std::chrono::duration<double, std::ratio<3600>>{age}.count();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = rotation_by(hours * rad_per_hour);
  X.translation() = hours * mm_per_hour;
  return X;
}

Eigen::Vector3d TripodDrift::moved(const Eigen::Vector3d& p_W_mm, std::chrono::duration<double> age) const {
  return motion(age) * p_W_mm;
}

}  // namespace truepose
