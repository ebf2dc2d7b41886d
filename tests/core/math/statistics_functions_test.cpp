#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/math/statistics.hpp"

namespace truepose {
namespace {

struct Quantile {
  int degrees;
  double x, tail;
};

TEST(ChiSquare, AgreesWithThePublishedTableOfItsQuantiles) {
  // Upper percentage points as printed in every table, to three decimals of x.
  const std::vector<Quantile> table{
      {1, 3.841, 0.05},    {1, 6.635, 0.01},    {1, 10.828, 0.001},   {2, 5.991, 0.05},
      {2, 9.210, 0.01},    {3, 7.815, 0.05},    {3, 16.266, 0.001},   {5, 11.070, 0.05},
      {6, 16.812, 0.01},   {9, 27.877, 0.001},  {10, 18.307, 0.05},   {10, 2.156, 0.995},
      {12, 21.026, 0.05},  {15, 24.996, 0.05},  {15, 30.578, 0.01},   {15, 37.697, 0.001},
      {15, 32.801, 0.005}, {30, 43.773, 0.05},  {30, 50.892, 0.01},   {60, 79.082, 0.05},
      {60, 88.379, 0.01},  {90, 113.145, 0.05}, {100, 124.342, 0.05}, {100, 67.328, 0.995},
  };
  for (const Quantile& q : table) {
    // The printed x is within 0.0005 of the exact one.
    EXPECT_GE(chi_square_tail(q.x - 0.00051, q.degrees), q.tail) << q.degrees << " " << q.tail;
    EXPECT_LE(chi_square_tail(q.x + 0.00051, q.degrees), q.tail) << q.degrees << " " << q.tail;
  }
}

TEST(ChiSquare, AgreesWithTheIncompleteGammaFunctionToForty) {
  // Gamma(degrees / 2, x / 2) / Gamma(degrees / 2), worked with forty digits.
  const std::vector<Quantile> exact{
      {1, 3.841, 0.050013683763956699076},     {15, 37.697, 0.0010001011230048282604},
      {15, 24.996, 0.049997178829693421779},   {15, 0.5, 0.99999999825535989578},
      {100, 124.342, 0.050000715769971767983}, {1500, 2000, 5.8099109897619926837e-17},
      {15, 500, 5.6526305298402936672e-97},    {3, 500, 4.7716720319127584629e-108},
  };
  for (const Quantile& q : exact)
    EXPECT_NEAR(chi_square_tail(q.x, q.degrees) / q.tail, 1, 1e-11) << q.degrees << " " << q.x;
}

TEST(ChiSquare, IsCertainBelowZeroAndFallsFromThere) {
  for (const int degrees : {1, 2, 7, 40}) {
    EXPECT_EQ(chi_square_tail(0, degrees), 1);
    EXPECT_EQ(chi_square_tail(-1, degrees), 1);
    double last = 1;
    for (double x = 0.1; x < 60; x += 0.1) {
      const double tail = chi_square_tail(x, degrees);
      EXPECT_LE(tail, last + 1e-14);
      last = tail;
    }
  }
}

TEST(PairedDifferences, FallByTheirMeanOverItsStandardError) {
  // Differences 1, 2, 3, 6: mean 3, sample variance 14 / 3, of the mean 14 / 12.
  const std::vector<double> before{11, 22, 33, 46}, after{10, 20, 30, 40};
  EXPECT_NEAR(standard_errors_gained(before, after), 3 / std::sqrt(14.0 / 12), 1e-14);
  EXPECT_NEAR(standard_errors_gained(after, before), -3 / std::sqrt(14.0 / 12), 1e-14);
}

TEST(PairedDifferences, ThatAreAllAlikeFallWithoutAnyDoubt) {
  const std::vector<double> before{3, 4, 5}, after{2, 3, 4};
  EXPECT_EQ(standard_errors_gained(before, after), HUGE_VAL);
  EXPECT_EQ(standard_errors_gained(after, before), -HUGE_VAL);
  EXPECT_EQ(standard_errors_gained(before, before), 0);
}

}  // namespace
}  // namespace truepose
