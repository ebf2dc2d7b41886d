#pragma once

namespace truepose {

/// The air that light goes through.
struct Air {
  double temperature_c = 20;
  double pressure_mbar = 1013.25;
  double humidity_percent = 50;
  bool operator==(const Air&) const = default;
};

/// Refractive index of air with 450 ppm of carbon dioxide for the phase of light, by which an interferometer
/// counts. Within 5e-8 from -40 to 100 C, from 800 to 1200 mbar and up to 100 %.
///
/// @param wavelength_um  in vacuum, 0.3 to 1.69
/// Source: Ciddor, Refractive index of air: new equations for the visible and near infrared, Applied Optics
/// 35 (1996).
double phase_index(const Air& air, double wavelength_um);

/// The same for a modulation of the light, by which an absolute distance meter measures: n - w dn/dw.
/// Source: Ciddor, Hill, Refractive index of air 2: group index, Applied Optics 38 (1999).
double group_index(const Air& air, double wavelength_um);

}  // namespace truepose
