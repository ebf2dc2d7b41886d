#include "core/math/refraction.hpp"

#include <cmath>

namespace truepose {
namespace {

constexpr double kZeroCelsius_K = 273.15;
constexpr double kGas = 8.314510;            // J / (mol K), as in the paper
constexpr double kDryMolar = 28.9641006e-3;  // kg / mol, with 450 ppm of carbon dioxide
constexpr double kVapourMolar = 0.018015;    // kg / mol
constexpr double kPaPerMbar = 100;

/// One constituent's refractivity (n - 1) in the paper's reference state.
struct Refractivity {
  double dry, vapour;
};

/// @param s2  squared wave number, 1/um^2
Refractivity phase_refractivity(double s2) {
  return {1e-8 * (5792105 / (238.0185 - s2) + 167917 / (57.362 - s2)),
          1.022e-8 * (295.235 + s2 * (2.6422 + s2 * (-0.032380 + s2 * 0.004028)))};
}

/// That plus the wave number times its derivative.
Refractivity group_refractivity(double s2) {
  const auto resonance = [s2](double strength, double at) {
    return strength * (at + s2) / ((at - s2) * (at - s2));
  };
  return {1e-8 * (resonance(5792105, 238.0185) + resonance(167917, 57.362)),
          1.022e-8 * (295.235 + s2 * (3 * 2.6422 + s2 * (5 * -0.032380 + s2 * 7 * 0.004028)))};
}

/// By how much moist air is denser than an ideal gas (BIPM 1981/91).
double compressibility(double t_c, double p_Pa, double vapour) {
  const double pt = p_Pa / (t_c + kZeroCelsius_K);
  return 1 -
         pt * (1.58123e-6 + t_c * (-2.9331e-8 + t_c * 1.1043e-10) + (5.707e-6 - 2.051e-8 * t_c) * vapour +
               (1.9898e-4 - 2.376e-6 * t_c) * vapour * vapour) +
         pt * pt * (1.83e-11 - 0.765e-8 * vapour * vapour);
}

/// Densities, kg / m^3.
struct Densities {
  double dry, vapour;
};

/// @param vapour  molar fraction of it
Densities densities(double t_c, double p_Pa, double vapour) {
  const double moles = p_Pa / (compressibility(t_c, p_Pa, vapour) * kGas * (t_c + kZeroCelsius_K));
  return {moles * kDryMolar * (1 - vapour), moles * kVapourMolar * vapour};
}

double vapour_fraction(double t_c, double p_Pa, double humidity) {
  const double T = t_c + kZeroCelsius_K;
  const double saturated_Pa =
      std::exp(1.2378847e-5 * T * T - 1.9121316e-2 * T + 33.93711047 - 6.3431645e3 / T);
  const double enhancement = 1.00062 + 3.14e-8 * p_Pa + 5.6e-7 * t_c * t_c;
  return enhancement * humidity * saturated_Pa / p_Pa;
}

double index(const Air& air, const Refractivity& reference) {
  static const Densities dry = densities(15, 101325, 0), vapour = densities(20, 1333, 1);
  const double p_Pa = air.pressure_mbar * kPaPerMbar;
  const Densities actual = densities(air.temperature_c, p_Pa,
                                     vapour_fraction(air.temperature_c, p_Pa, air.humidity_percent / 100));
  return 1 + actual.dry / dry.dry * reference.dry + actual.vapour / vapour.vapour * reference.vapour;
}

double squared_wave_number(double wavelength_um) { return 1 / (wavelength_um * wavelength_um); }

}  // namespace

double phase_index(const Air& air, double wavelength_um) {
  return index(air, phase_refractivity(squared_wave_number(wavelength_um)));
}

double group_index(const Air& air, double wavelength_um) {
  return index(air, group_refractivity(squared_wave_number(wavelength_um)));
}

}  // namespace truepose
