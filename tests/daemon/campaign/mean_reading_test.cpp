#include "daemon/campaign/mean_reading.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <span>

#include "core/math/angles.hpp"

namespace truepose::daemon {
namespace {

TEST(MeanReading, ScattersAsAMeanOfIndependentReadingsDoes) {
  const std::array<drivers::SmrPoint, 3> readings{{{.p_WS_mm = {1, 2, 3}, .std_mm = {0.003, 0.006, 0}},
                                                   {.p_WS_mm = {2, 4, 3}, .std_mm = {0.004, 0.006, 0}},
                                                   {.p_WS_mm = {3, 0, 6}, .std_mm = {0.012, 0.006, 0.009}}}};
  const drivers::SmrPoint mean = mean_reading(readings);
  EXPECT_TRUE(mean.p_WS_mm.isApprox(Eigen::Vector3d{2, 2, 4}, 1e-15));
  // sqrt(9 + 16 + 144) = 13; three alike: a third, times sqrt(3); one alone: a third.
  EXPECT_TRUE(mean.std_mm.isApprox(Eigen::Vector3d{0.013 / 3, 0.00346410161513775, 0.003}, 1e-12));
}

TEST(MeanReading, OfBothFacesIsHalfTheRootOfTheirSquares) {
  const std::array<drivers::SmrPoint, 2> faces{{{.p_WS_mm = {1000, 0, 0}, .std_mm = {0.003, 0.005, 0.008}},
                                                {.p_WS_mm = {1001, 0, 0}, .std_mm = {0.004, 0.012, 0.006}}}};
  const drivers::SmrPoint mean = mean_reading(faces);
  EXPECT_TRUE(mean.p_WS_mm.isApprox(Eigen::Vector3d{1000.5, 0, 0}, 1e-15));
  EXPECT_TRUE(mean.std_mm.isApprox(Eigen::Vector3d{0.0025, 0.0065, 0.005}, 1e-12));
}

TEST(MeanReading, HasTheMeanOfTheAir) {
  const std::array<drivers::SmrPoint, 3> readings{
      {{.temperature_c = 20, .pressure_mbar = 1000, .humidity_percent = 40},
       {.temperature_c = 21, .pressure_mbar = 1001, .humidity_percent = 50},
       {.temperature_c = 25, .pressure_mbar = 1005, .humidity_percent = 60}}};
  const drivers::SmrPoint mean = mean_reading(readings);
  EXPECT_DOUBLE_EQ(mean.temperature_c, 22);
  EXPECT_DOUBLE_EQ(mean.pressure_mbar, 1002);
  EXPECT_DOUBLE_EQ(mean.humidity_percent, 50);
}

TEST(MeanReading, TurnsAsTheMeanOfItsOrientations) {
  const Eigen::Matrix3d R_WT = rotation_zyx(2.1, -0.4, 0.9);
  const auto turned = [&](double x, double y) {
    return MeasuredOrientation{rotation_by({x, y, 0}) * R_WT, 2e-4};
  };
  std::array<drivers::SmrPoint, 4> readings;
  readings[0].orientation = turned(1e-4, 0);
  readings[1].orientation = turned(-1e-4, 3e-4);
  readings[2].orientation = turned(0, -3e-4);
  const auto mean = mean_reading(readings).orientation;  // the fourth has none
  ASSERT_TRUE(mean);
  EXPECT_LT(angle_between(mean->R_WT, R_WT), 1e-7);
  EXPECT_NEAR(mean->sigma_rad, 2e-4 / std::sqrt(3), 1e-15);
  EXPECT_FALSE(mean_reading(std::span{readings}.last(1)).orientation);
}

TEST(MeanReading, OfOneIsThatOne) {
  const std::array<drivers::SmrPoint, 1> one{{{.p_WS_mm = {1.1, -2.3, 0.7},
                                               .std_mm = {0.0031, 0.0047, 0.0113},
                                               .temperature_c = 21.7,
                                               .pressure_mbar = 987.3,
                                               .humidity_percent = 43.1}}};
  const drivers::SmrPoint mean = mean_reading(one);
  EXPECT_EQ(mean.p_WS_mm, one[0].p_WS_mm);
  EXPECT_EQ(mean.std_mm, one[0].std_mm);
  EXPECT_EQ(mean.temperature_c, one[0].temperature_c);
  EXPECT_EQ(mean.pressure_mbar, one[0].pressure_mbar);
  EXPECT_EQ(mean.humidity_percent, one[0].humidity_percent);
}

}  // namespace
}  // namespace truepose::daemon
