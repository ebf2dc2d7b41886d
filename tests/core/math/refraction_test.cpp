#include "core/math/refraction.hpp"

#include <gtest/gtest.h>

#include <array>

namespace truepose {
namespace {

constexpr double kHeNe_um = 0.633;

struct Case {
  double t_c, p_mbar, humidity_percent, wavelength_um, index;
};

// The values by which the NIST Engineering Metrology Toolbox has its own Ciddor equation checked.
constexpr std::array<Case, 14> kNist{{{20, 1013.25, 0, 0.633, 1.000271800},
                                      {20, 600, 0, 0.633, 1.000160924},
                                      {20, 1200, 0, 0.633, 1.000321916},
                                      {50, 1000, 0, 0.633, 1.000243285},
                                      {5, 1000, 0, 0.633, 1.000282756},
                                      {-40, 1000, 0, 0.633, 1.000337580},
                                      {50, 1200, 100, 0.633, 1.000287924},
                                      {40, 1200, 75, 0.633, 1.000299418},
                                      {20, 1000, 100, 0.633, 1.000267394},
                                      {40, 1100, 100, 1.7, 1.000270247},
                                      {20, 1013.25, 0, 1.7, 1.000268479},
                                      {40, 1100, 100, 0.3, 1.000289000},
                                      {20, 1013.25, 0, 0.3, 1.000286581},
                                      {-40, 1200, 0, 0.3, 1.000427233}}};

// Ciddor 1996, tables 1 and 3, as refractivity.
constexpr std::array<Case, 10> kCiddor{{{20, 800, 0, 0.633, 21458.0},
                                        {20, 1000, 0, 0.633, 26824.4},
                                        {20, 1200, 0, 0.633, 32191.6},
                                        {10, 1000, 0, 0.633, 27774.7},
                                        {30, 1000, 0, 0.633, 25937.2},
                                        {20, 800, 75, 0.633, 21394.0},
                                        {20, 1200, 75, 0.633, 32127.8},
                                        {40, 1200, 75, 0.633, 29941.8},
                                        {50, 800, 100, 0.633, 19058.4},
                                        {50, 1200, 100, 0.633, 28792.4}}};

Air air_of(const Case& of) { return {of.t_c, of.p_mbar, of.humidity_percent}; }

TEST(Refraction, AgreesWithTheValuesOfNist) {
  for (const Case& of : kNist)
    EXPECT_NEAR(phase_index(air_of(of), of.wavelength_um), of.index, 2e-9)
        << of.t_c << " C, " << of.p_mbar << " mbar, " << of.humidity_percent << " %, " << of.wavelength_um
        << " um";
}

TEST(Refraction, AgreesWithTheTablesOfThePaper) {
  for (const Case& of : kCiddor)
    EXPECT_NEAR(1e8 * (phase_index(air_of(of), of.wavelength_um) - 1), of.index, 0.15)
        << of.t_c << " C, " << of.p_mbar << " mbar, " << of.humidity_percent << " %";
}

TEST(Refraction, OfTheGroupIsThatOfThePhaseLessItsSlope) {
  constexpr double kStep_um = 1e-4;
  for (const double w_um : {0.532, 0.633, 0.78, 0.795, 1.55}) {
    for (const Air& air : {Air{20, 1013.25, 0}, Air{35, 950, 90}, Air{-5, 1040, 30}}) {
      const double slope =
          (phase_index(air, w_um + kStep_um) - phase_index(air, w_um - kStep_um)) / (2 * kStep_um);
      EXPECT_NEAR(group_index(air, w_um), phase_index(air, w_um) - w_um * slope, 1e-11) << w_um;
    }
  }
}

TEST(Refraction, GivesAKelvinAndFourMillibarsAMicrometreAMetre) {
  const Air air;
  EXPECT_NEAR(
      phase_index({21, air.pressure_mbar, air.humidity_percent}, kHeNe_um) - phase_index(air, kHeNe_um),
      -0.95e-6, 0.02e-6);
  EXPECT_NEAR(
      phase_index({20, air.pressure_mbar + 4, air.humidity_percent}, kHeNe_um) - phase_index(air, kHeNe_um),
      1.07e-6, 0.02e-6);
}

}  // namespace
}  // namespace truepose
