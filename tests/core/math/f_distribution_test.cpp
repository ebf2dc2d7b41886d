#include "core/math/f_distribution.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/statistics.hpp"

namespace truepose {
namespace {

TEST(FDistribution, AgreesWithThePublishedTableOfItsQuantiles) {
  // Upper percentage points as printed in every table, to two decimals of x.
  struct Row {
    double above, below, x, tail;
  };
  for (const Row& row :
       {Row{1, 1, 161.45, 0.05}, Row{3, 10, 3.71, 0.05}, Row{5, 2, 99.30, 0.01}, Row{12, 60, 1.92, 0.05},
        Row{12, 60, 2.50, 0.01}, Row{3, 30, 4.51, 0.01}, Row{10, 15, 2.54, 0.05}, Row{24, 120, 1.61, 0.05}}) {
    EXPECT_GE(f_tail(row.x - 0.0051, row.above, row.below), row.tail) << row.above << " " << row.below;
    EXPECT_LE(f_tail(row.x + 0.0051, row.above, row.below), row.tail) << row.above << " " << row.below;
  }
}

TEST(FDistribution, IsExactWhereItHasAClosedForm) {
  for (const double below : {1.0, 7.0, 52.5, 400.0})
    for (const double x : {0.01, 0.5, 1.0, 4.0, 60.0})
      EXPECT_NEAR(f_tail(x, 2, below) / std::pow(1 + 2 * x / below, -below / 2), 1, 1e-11)
          << below << " " << x;
}

TEST(FDistribution, IsTheChiSquareWhereTheDenominatorIsKnown) {
  for (const double x : {0.3, 1.0, 2.0, 3.0})
    EXPECT_NEAR(f_tail(x, 12, 1e8) / chi_square_tail(12 * x, 12), 1, 1e-5) << x;
}

TEST(FDistribution, OfTheReciprocalIsTheRest) {
  for (const double x : {0.2, 0.9, 1.0, 3.0, 8.0})
    EXPECT_NEAR(f_tail(x, 3, 17) + f_tail(1 / x, 17, 3), 1, 1e-13) << x;
}

}  // namespace
}  // namespace truepose
