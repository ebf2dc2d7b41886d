#include "core/compensate/correction_bounds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <random>

namespace truepose {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kDeg = kRadPerDeg;

JointVector axes(std::initializer_list<double> values_deg) {
  JointVector q(static_cast<Eigen::Index>(values_deg.size()));
  Eigen::Index i = 0;
  for (const double value : values_deg) q[i++] = value * kDeg;
  return q;
}

const JointVector kZero = JointVector::Zero(6);
const JointVector kPose = axes({10, -80, 90, 20, 45, -30});

CorrectionBounds bounds() {
  return {.max_step = 0.02 * kDeg,
          .max_total = 3 * kDeg,
          .min = axes({-185, -140, -120, -350, -125, -350}),
          .max = axes({185, -5, 168, 350, 125, 350}),
          .limit_margin = 1 * kDeg};
}

CorrectionBounds wide_step() {
  CorrectionBounds wide = bounds();
  wide.max_step = 100 * kDeg;
  return wide;
}

/// Where one value is in effect.
BoundedCorrection bound_correction(const JointVector& wanted, const JointVector& last,
                                   const JointVector& commanded, const CorrectionBounds& bounds) {
  return truepose::bound_correction(wanted, CorrectionRange::of(last), commanded, bounds);
}

void expect_axes_near(const JointVector& actual, const JointVector& expected_rad) {
  ASSERT_EQ(actual.size(), expected_rad.size());
  for (Eigen::Index i = 0; i < actual.size(); ++i) {
    EXPECT_NEAR(actual[i], expected_rad[i], 1.01e-6 * kDeg) << "axis " << i + 1;
  }
}

TEST(CorrectionBounds, LetASmallCorrectionPass) {
  const JointVector wanted = axes({0.01, -0.015, 0.002, 0.019, -0.02, 0.0});
  const BoundedCorrection result = bound_correction(wanted, kZero, kPose, bounds());
  expect_axes_near(result.correction, wanted);
  EXPECT_FALSE(result.clamps.broken());
}

TEST(CorrectionBounds, MoveAtMostOneStepPerCycleAndAxis) {
  const JointVector last = axes({0.1, 0.1, -0.1, 0, 0, 0});
  const BoundedCorrection result =
      bound_correction(axes({0.5, -0.5, -0.11, 0, 2.9, 0}), last, kPose, bounds());
  expect_axes_near(result.correction, axes({0.12, 0.08, -0.11, 0, 0.02, 0}));
  EXPECT_TRUE(result.clamps.step);
  EXPECT_FALSE(result.clamps.total);
}

TEST(CorrectionBounds, MakeACorrectionBeyondTheTotalSmallerAsAWhole) {
  const BoundedCorrection result =
      bound_correction(axes({1, 2.5, -5, 3, -3.0001, 0}), kZero, kPose, wide_step());
  expect_axes_near(result.correction, axes({0.6, 1.5, -3, 1.8, -1.80006, 0}));
  EXPECT_TRUE(result.clamps.total);
  EXPECT_FALSE(result.clamps.step);
}

TEST(CorrectionBounds, KeepCommandedPlusCorrectionInsideTheJointLimits) {
  const JointVector pose = axes({183.5, -138.5, 90, 20, 45, -30});
  const BoundedCorrection result = bound_correction(axes({2, -2, 2, 0, 0, 0}), kZero, pose, wide_step());
  expect_axes_near(result.correction, axes({0.5, -0.5, 2, 0, 0, 0}));
  EXPECT_TRUE(result.clamps.limit);
}

TEST(CorrectionBounds, NeverPushAProgramThatIsBeyondALimitFurtherOut) {
  const JointVector pose = axes({186, -140, 90, 20, 45, -30});
  const BoundedCorrection out = bound_correction(axes({1, -1, 0, 0, 0, 0}), kZero, pose, wide_step());
  expect_axes_near(out.correction, kZero);
  const BoundedCorrection in = bound_correction(axes({-1, 0.5, 0, 0, 0, 0}), kZero, pose, wide_step());
  expect_axes_near(in.correction, axes({-1, 0.5, 0, 0, 0, 0}));
  EXPECT_FALSE(in.clamps.limit);
}

TEST(CorrectionBounds, ApproachATotalThatWasLoweredByBoundedSteps) {
  CorrectionBounds lowered = bounds();
  lowered.max_total = 0.5 * kDeg;
  JointVector correction = axes({1, -1, 0, 0, 0, 0});
  for (int cycle = 1; cycle <= 25; ++cycle) {
    correction = bound_correction(axes({1, -1, 0, 0, 0, 0}), correction, kPose, lowered).correction;
    expect_axes_near(correction, axes({1 - 0.02 * cycle, -1 + 0.02 * cycle, 0, 0, 0, 0}));
  }
  EXPECT_FALSE(bound_correction(axes({1, -1, 0, 0, 0, 0}), correction, kPose, lowered).clamps.step);
}

TEST(CorrectionBounds, HoldTheLastCorrectionOnAnyNumberThatIsNotFinite) {
  const JointVector last = axes({0.1, -0.2, 0.3, 0, 0.05, 1});
  const JointVector wanted = axes({0.11, -0.2, 0.3, 0, 0.05, 1});
  const auto expect_hold = [&](const JointVector& wish, const JointVector& pose, const CorrectionBounds& b) {
    const BoundedCorrection result = bound_correction(wish, last, pose, b);
    EXPECT_EQ(result.correction, last);
    EXPECT_TRUE(result.clamps.not_finite);
  };
  for (const double bad : {kNan, kInf, -kInf}) {
    for (Eigen::Index i = 0; i < 6; ++i) {
      JointVector broken = wanted;
      broken[i] = bad;
      expect_hold(broken, kPose, bounds());
      broken = kPose;
      broken[i] = bad;
      expect_hold(wanted, broken, bounds());
    }
    CorrectionBounds b = bounds();
    b.max_step = bad;
    expect_hold(wanted, kPose, b);
    b = bounds();
    b.max_total = bad;
    expect_hold(wanted, kPose, b);
    b = bounds();
    b.limit_margin = bad;
    expect_hold(wanted, kPose, b);
    b = bounds();
    b.resolution = bad;
    expect_hold(wanted, kPose, b);
  }
  CorrectionBounds b = bounds();
  b.min[3] = kNan;
  expect_hold(wanted, kPose, b);
  expect_hold(JointVector::Zero(5), kPose, bounds());
  expect_hold(wanted, JointVector::Zero(7), bounds());
  expect_hold(wanted, kPose, CorrectionBounds{});
}

TEST(CorrectionBounds, ReplaceALastCorrectionThatIsNotFiniteByZero) {
  JointVector last = kZero;
  last[2] = kNan;
  const BoundedCorrection result = bound_correction(kZero, last, kPose, bounds());
  EXPECT_EQ(result.correction, kZero);
  EXPECT_TRUE(result.clamps.not_finite);
}

TEST(CorrectionBounds, AcceptAxesWithoutLimits) {
  CorrectionBounds b = wide_step();
  b.min.setConstant(-kInf);
  b.max.setConstant(kInf);
  const BoundedCorrection result = bound_correction(axes({1, -1, 1, 0, 0, 0}), kZero, kPose, b);
  expect_axes_near(result.correction, axes({1, -1, 1, 0, 0, 0}));
}

TEST(CorrectionBounds, RampToExactlyZero) {
  JointVector correction = axes({1.234567, -0.7, 2.999999, 0.000001, -1.5, 0.3});
  for (int cycle = 0; cycle < 151; ++cycle) {
    correction = bound_correction(kZero, correction, kPose, bounds()).correction;
  }
  EXPECT_EQ(correction, kZero);
}

TEST(CorrectionBounds, WorkForAnyNumberOfAxes) {
  for (const int axis_count : {1, 2, 5, 7, kMaxJoints}) {
    CorrectionBounds b = bounds();
    b.min = JointVector::Constant(axis_count, -1);
    b.max = JointVector::Constant(axis_count, 1);
    const JointVector wanted = JointVector::Constant(axis_count, 0.01 * kDeg);
    const JointVector zero = JointVector::Zero(axis_count);
    expect_axes_near(bound_correction(wanted, zero, JointVector::Constant(axis_count, 0.5), b).correction,
                     wanted);
  }
}

/// Numbers as only a broken program sends them, among ordinary ones.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : random_{seed} {}

  double ordinary(double scale) { return std::uniform_real_distribution<double>{-scale, scale}(random_); }

  double nasty(double scale) {
    switch (pick(24)) {
      case 0:
        return kNan;
      case 1:
        return kInf;
      case 2:
        return -kInf;
      case 3:
        return std::numeric_limits<double>::max();
      case 4:
        return std::numeric_limits<double>::lowest();
      case 5:
        return std::numeric_limits<double>::denorm_min();
      case 6:
        return -0.0;
      case 7:
        return ordinary(1e12);
      case 8:
        return ordinary(1e-12);
      default:
        return ordinary(scale);
    }
  }

  JointVector nasty_axes(double scale) {
    JointVector q(6);
    for (double& value : q) value = pick(8) == 0 ? nasty(scale) : ordinary(scale);
    return q;
  }

  int pick(int n) { return std::uniform_int_distribution{0, n - 1}(random_); }

 private:
  std::mt19937_64 random_;
};

double grid(double value, double resolution) { return std::nearbyint(value / resolution) * resolution; }

TEST(CorrectionBounds, HoldForWhateverNumbersComeIn) {
  constexpr std::uint64_t kSeed = 20260817;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Numbers numbers{kSeed};
  for (int round = 0; round < 100'000; ++round) {
    CorrectionBounds b = bounds();
    b.max_step = std::abs(numbers.ordinary(0.1 * kDeg));
    b.max_total = std::abs(numbers.ordinary(4 * kDeg));
    if (numbers.pick(10) == 0) b.min = numbers.nasty_axes(3);
    if (numbers.pick(10) == 0) b.max = numbers.nasty_axes(3);
    if (numbers.pick(20) == 0) b.limit_margin = numbers.nasty(0.1);
    JointVector last(6);
    const double reach = numbers.pick(4) == 0 ? 2 * b.max_total : b.max_total;
    for (double& value : last)
      value = grid(std::trunc(numbers.ordinary(reach) / b.resolution) * b.resolution, b.resolution);
    const JointVector wanted = numbers.nasty_axes(5 * kDeg);
    const JointVector commanded = numbers.nasty_axes(3);

    const BoundedCorrection result = bound_correction(wanted, last, commanded, b);

    ASSERT_EQ(result.correction.size(), 6);
    ASSERT_TRUE(result.correction.allFinite()) << "round " << round;
    const bool finite = wanted.allFinite() && commanded.allFinite();
    if (!finite) {
      ASSERT_TRUE(result.clamps.not_finite) << "round " << round;
    }
    for (Eigen::Index i = 0; i < 6; ++i) {
      const double correction = result.correction[i];
      ASSERT_LE(std::abs(correction - last[i]), b.max_step + 1e-13) << "round " << round;
      if (std::abs(last[i]) <= b.max_total) {
        ASSERT_LE(std::abs(correction), b.max_total + 1e-13) << "round " << round;
      } else {
        ASSERT_LE(std::abs(correction), std::abs(last[i]) + 1e-13) << "round " << round;
      }
      if (result.clamps.not_finite) {
        ASSERT_EQ(correction, last[i]) << "round " << round;
      }
      ASSERT_NEAR(correction, grid(correction, b.resolution), 1e-15) << "round " << round;
    }
    if (!result.clamps.broken()) {
      for (Eigen::Index i = 0; i < 6; ++i) {
        ASSERT_NEAR(result.correction[i], wanted[i], 1.01 * b.resolution) << "round " << round;
      }
    }
  }
}

TEST(CorrectionBounds, StayWithinAStepOfAllThatMayBeInForce) {
  constexpr std::uint64_t kSeed = 31;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Numbers numbers{kSeed};
  const CorrectionBounds b = bounds();
  for (int round = 0; round < 20'000; ++round) {
    CorrectionRange in_effect = CorrectionRange::of(axes({0.5, -1, 0, 2, 0.01, -0.3}));
    for (int sent = numbers.pick(3); sent >= 0; --sent) {
      JointVector also = in_effect.min;
      for (double& value : also) value += numbers.ordinary(0.012 * kDeg);
      in_effect.include(also);
    }
    const BoundedCorrection result =
        truepose::bound_correction(numbers.nasty_axes(3 * kDeg), in_effect, kPose, b);
    if (!in_effect.within_reach(b.max_step - b.resolution)) continue;
    ASSERT_LE((result.correction - in_effect.min).cwiseAbs().maxCoeff(), b.max_step + 1e-13)
        << "round " << round;
    ASSERT_LE((result.correction - in_effect.max).cwiseAbs().maxCoeff(), b.max_step + 1e-13)
        << "round " << round;
  }
}

TEST(CorrectionBounds, KnowWhatIsOutOfReachOfOneStep) {
  CorrectionRange in_effect = CorrectionRange::of(kZero);
  in_effect.include(axes({0, 0.04, 0, 0, 0, 0}));
  EXPECT_TRUE(in_effect.within_reach(0.02 * kDeg + 1e-12));
  in_effect.include(axes({0, 0, -0.041, 0, 0, 0}));
  EXPECT_FALSE(in_effect.within_reach(0.02 * kDeg));
}

TEST(CorrectionBounds, KeepALongWalkOfWishesWithinStepsAndTotal) {
  constexpr std::uint64_t kSeed = 4711;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Numbers numbers{kSeed};
  const CorrectionBounds b = bounds();
  JointVector commanded = kPose;
  JointVector wanted = kZero;
  JointVector correction = kZero;
  for (int cycle = 0; cycle < 200'000; ++cycle) {
    if (numbers.pick(200) == 0) wanted = numbers.nasty_axes(6 * kDeg);
    const JointVector last = correction;
    correction = bound_correction(wanted, last, commanded, b).correction;
    ASSERT_TRUE(correction.allFinite());
    ASSERT_LE((correction - last).cwiseAbs().maxCoeff(), b.max_step + 1e-13) << "cycle " << cycle;
    ASSERT_LE(correction.cwiseAbs().maxCoeff(), b.max_total + 1e-13) << "cycle " << cycle;
  }
}

TEST(CorrectionBounds, ReachEveryReachableWishAndStayThere) {
  constexpr std::uint64_t kSeed = 99;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Numbers numbers{kSeed};
  JointVector correction = kZero;
  for (int round = 0; round < 200; ++round) {
    JointVector wanted(6);
    for (double& value : wanted) value = numbers.ordinary(3 * kDeg);
    for (int cycle = 0; cycle < 301; ++cycle)
      correction = bound_correction(wanted, correction, kPose, bounds()).correction;
    expect_axes_near(correction, wanted);
    const BoundedCorrection again = bound_correction(wanted, correction, kPose, bounds());
    EXPECT_EQ(again.correction, correction);
    EXPECT_FALSE(again.clamps.broken());
  }
}

}  // namespace
}  // namespace truepose
