#include "core/change/drift_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "core/math/angles.hpp"
#include "core/quality/model_noise.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose {
namespace {

/// A cell whose model is exact, and five points spread over its joints.
class DriftOfAnExactModel : public testing::Test {
 protected:
  DriftOfAnExactModel() {
    reference_.cell = {.robot = published_arm(),
                       .base = {.p_mm = {4000, 500, -300}, .rxyz_rad = {0, 0, 2.1}},
                       .reflectors = {{"left", {80, 40, 120}}}};
    reference_.noise.repeatability_mm = 0.02;
    reference_.validation_mean_mm = 0.032;
    for (const auto& deg : {std::array{-60.0, -60.0, 60.0, 40.0, 50.0, -120.0},
                            {-20.0, -110.0, 120.0, -80.0, -40.0, 60.0},
                            {15.0, -45.0, 30.0, 120.0, 70.0, 170.0},
                            {45.0, -90.0, 100.0, -20.0, -90.0, -30.0},
                            {80.0, -75.0, 70.0, -150.0, 30.0, 100.0}}) {
      const JointVector q = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(deg.data()) * kRadPerDeg;
      joints_.push_back(q);
    }
  }

  /// What the changed cell shows, exactly.
  std::vector<Measurement> points_of(const CalibratedCell& cell) const {
    std::vector<Measurement> points;
    for (const JointVector& q : joints_)
      points.push_back({.q = q, .p_WS_mm = cell.predict(q, 0), .row = static_cast<int>(points.size()) + 1});
    return points;
  }

  DriftCheck check(const std::vector<Measurement>& points) const {
    const auto result = drift_check(reference_, points);
    EXPECT_TRUE(result) << (result ? "" : result.error());
    return result ? *result : DriftCheck{};
  }
  DriftCheck check(const CalibratedCell& cell) const { return check(points_of(cell)); }

  DriftReference reference_;
  std::vector<JointVector> joints_;
};

TEST_F(DriftOfAnExactModel, AnUnchangedCellIsOk) {
  const DriftCheck result = check(reference_.cell);
  EXPECT_EQ(result.verdict, DriftVerdict::Ok);
  EXPECT_EQ(result.probability, 1);
  EXPECT_EQ(result.degrees, 15);
  EXPECT_TRUE(result.causes.empty());
  EXPECT_EQ(result.reason,
            "the points agree with the model: off by 0.000 mm on average, against 0.032 mm at validation");
}

TEST_F(DriftOfAnExactModel, AMovedTrackerIsNamedWithTheWayAndTheTurn) {
  CalibratedCell cell = reference_.cell;
  Eigen::Isometry3d X_WB = cell.base.isometry();
  X_WB.translation() += Eigen::Vector3d(0.12, -0.16, 0.15);
  X_WB.linear() = Eigen::AngleAxisd(0.01 * kRadPerDeg, Eigen::Vector3d::UnitX()) * X_WB.linear();
  cell.base = BasePose::of(X_WB);
  const DriftCheck result = check(cell);
  EXPECT_EQ(result.verdict, DriftVerdict::Failed);
  ASSERT_FALSE(result.causes.empty());
  EXPECT_EQ(result.causes[0].what.kind, ChangeKind::Base);
  EXPECT_NE(result.reason.find("most likely the tracker or the base moved by 0.25 mm and 0.0100 deg: fit the "
                               "frame again"),
            std::string::npos)
      << result.reason;
}

TEST_F(DriftOfAnExactModel, ATrackerThatWasSetUpElsewhereIsNamedHoweverFarItWent) {
  CalibratedCell cell = reference_.cell;
  const Eigen::Isometry3d X = pose_from_kuka({-3000, 2500, 400}, {150, 2, -3});
  cell.base = BasePose::of(X * cell.base.isometry());
  const DriftCheck result = check(cell);
  EXPECT_EQ(result.verdict, DriftVerdict::Failed);
  ASSERT_FALSE(result.causes.empty());
  EXPECT_EQ(result.causes[0].what.kind, ChangeKind::Base);
  EXPECT_GT(result.causes[0].probability, 0.99);
  EXPECT_TRUE(result.alternatives.empty());
}

TEST_F(DriftOfAnExactModel, AnAxisThatWasMasteredWronglyByDegreesIsNamed) {
  CalibratedCell cell = reference_.cell;
  cell.robot.joints[3].theta_rad += 5 * kRadPerDeg;
  const DriftCheck result = check(cell);
  ASSERT_FALSE(result.causes.empty());
  EXPECT_EQ(result.causes[0].what.kind, ChangeKind::JointZero);
  EXPECT_EQ(result.causes[0].what.index, 3);
  EXPECT_NEAR(result.causes[0].moved[0] * kDegPerRad, -5, 1e-6);
}

TEST_F(DriftOfAnExactModel, AMovedReflectorIsNamed) {
  CalibratedCell cell = reference_.cell;
  cell.reflectors[0].p_FS_mm += Eigen::Vector3d(0.2, 0, -0.15);
  const DriftCheck result = check(cell);
  EXPECT_EQ(result.verdict, DriftVerdict::Failed);
  ASSERT_FALSE(result.causes.empty());
  EXPECT_EQ(result.causes[0].what.kind, ChangeKind::Reflector);
  EXPECT_LT((result.causes[0].moved - Eigen::Vector3d(0.2, 0, -0.15)).norm(), 1e-6);
  EXPECT_NE(result.reason.find("reflector 'left' moved on the flange by 0.25 mm"), std::string::npos)
      << result.reason;
}

TEST_F(DriftOfAnExactModel, EveryJointsZeroIsNamedInTheJointsOwnSense) {
  for (int joint = 0; joint < 6; ++joint) {
    // The arm stands where its encoders would read 0.05 deg more.
    std::vector<Measurement> points = points_of(reference_.cell);
    for (Measurement& point : points) {
      JointVector q = point.q;
      q[joint] += 0.05 * kRadPerDeg;
      point.p_WS_mm = reference_.cell.predict(q, 0);
    }
    const DriftCheck result = check(points);
    EXPECT_NE(result.verdict, DriftVerdict::Ok) << joint;
    ASSERT_FALSE(result.causes.empty());
    EXPECT_EQ(result.causes[0].what.kind, ChangeKind::JointZero) << joint;
    EXPECT_EQ(result.causes[0].what.index, joint);
    EXPECT_NEAR(result.causes[0].moved[0] * kDegPerRad, 0.05, 1e-6);
  }
}

TEST_F(DriftOfAnExactModel, AxisOnesZeroIsIndistinguishableFromABaseThatTurnsAboutIt) {
  CalibratedCell cell = reference_.cell;
  cell.robot.joints[0].theta_rad += 0.02 * kRadPerDeg;
  const DriftCheck result = check(cell);
  ASSERT_FALSE(result.causes.empty());
  EXPECT_EQ(result.causes[0].what.kind, ChangeKind::JointZero);
  ASSERT_EQ(result.alternatives.size(), 1U);
  EXPECT_EQ(result.alternatives[0].what.kind, ChangeKind::Base);
  EXPECT_NE(result.reason.find("axis 1's zero moved by -0.0200 deg, or the tracker or the base moved"),
            std::string::npos)
      << result.reason;
  EXPECT_NE(result.reason.find("(these points do not separate them)"), std::string::npos);
}

TEST_F(DriftOfAnExactModel, OneWrongReadingIsAWarningToMeasureItAgain) {
  std::vector<Measurement> points = points_of(reference_.cell);
  points[3].p_WS_mm.y() += 0.8;
  const DriftCheck result = check(points);
  EXPECT_EQ(result.verdict, DriftVerdict::Warning);
  ASSERT_FALSE(result.causes.empty());
  EXPECT_EQ(result.causes[0].what.kind, ChangeKind::Reading);
  EXPECT_NE(result.reason.find("the reading of point 4 alone is off by 0.80 mm"), std::string::npos)
      << result.reason;
}

TEST_F(DriftOfAnExactModel, WhatNoSingleCauseExplainsIsTheArmItself) {
  CalibratedCell cell = reference_.cell;
  for (Joint& joint : cell.robot.joints) {
    joint.a_mm += 0.3;
    joint.alpha_rad -= 4e-4;
    joint.beta_rad += 3e-4;
    joint.theta_rad += 2e-4;
  }
  const DriftCheck result = check(cell);
  EXPECT_EQ(result.verdict, DriftVerdict::Failed);
  EXPECT_NE(result.reason.find("the arm itself has changed, calibrate again"), std::string::npos)
      << result.reason;
}

TEST_F(DriftOfAnExactModel, SeveralChangesAtOnceAreNamedAndNotTakenForTheArm) {
  CalibratedCell cell = reference_.cell;
  cell.base.p_mm += Eigen::Vector3d(0.3, 0.2, 0.1);
  joints_.push_back(0.5 * (joints_[0] + joints_[1]));
  joints_.push_back(0.5 * (joints_[2] + joints_[3]));
  joints_.push_back(0.5 * (joints_[1] + joints_[4]));
  std::vector<Measurement> points = points_of(cell);
  points[3].p_WS_mm.x() += 1;
  const DriftCheck result = check(points);
  EXPECT_EQ(result.verdict, DriftVerdict::Failed);
  for (const char* part :
       {"these together do", "the tracker or the base moved by 0.3", "the reading of point 4"})
    EXPECT_NE(result.reason.find(part), std::string::npos) << result.reason;
  EXPECT_EQ(result.reason.find("the arm itself"), std::string::npos) << result.reason;
}

TEST_F(DriftOfAnExactModel, PointsOfOtherUnitsColumnsOrRowsAreReportedAsThat) {
  struct Wrong {
    std::function<void(std::vector<Measurement>&)> make;
    const char* part;
  };
  const auto each = [](auto change) {
    return [=](std::vector<Measurement>& points) { std::ranges::for_each(points, change); };
  };
  for (const Wrong& wrong :
       {Wrong{each([](Measurement& point) { point.p_WS_mm /= 1000; }), "the points are in m, not mm"},
        Wrong{each([](Measurement& point) { point.q *= kRadPerDeg; }),
              "joint angles of the measurements are in rad"},
        Wrong{each([](Measurement& point) { std::swap(point.p_WS_mm[0], point.p_WS_mm[1]); }),
              "two of the columns x, y and z"},
        Wrong{each([](Measurement& point) { std::swap(point.q[1], point.q[2]); }),
              "q2 and q3 of the measurements are swapped"},
        Wrong{[](std::vector<Measurement>& points) {
                for (std::size_t i = 0; i + 1 < points.size(); ++i) points[i].q = points[i + 1].q;
                points.pop_back();
              },
              "the joint positions stand a row above their points"}}) {
    std::vector<Measurement> points = points_of(reference_.cell);
    wrong.make(points);
    const DriftCheck result = check(points);
    EXPECT_EQ(result.verdict, DriftVerdict::Failed);
    EXPECT_NE(result.reason.find(wrong.part), std::string::npos) << result.reason;
  }
}

TEST_F(DriftOfAnExactModel, TooFewPointsAreSaidToBeTooFew) {
  CalibratedCell cell = reference_.cell;
  cell.base.p_mm.x() += 5;
  cell.reflectors[0].p_FS_mm.y() += 5;
  joints_.resize(1);
  const DriftCheck result = check(cell);
  EXPECT_EQ(result.verdict, DriftVerdict::Failed);
  EXPECT_NE(result.reason.find("1 point is too few to find the cause: measure at least 4"), std::string::npos)
      << result.reason;
}

TEST_F(DriftOfAnExactModel, AsManyPointsAsAreAskedForAreEnough) {
  CalibratedCell cell = reference_.cell;
  cell.robot.joints[2].theta_rad += 0.02 * kRadPerDeg;
  joints_.resize(4);
  EXPECT_EQ(check(cell).reason.find("too few"), std::string::npos) << check(cell).reason;
  joints_.pop_back();
  EXPECT_NE(check(cell).reason.find("3 points are too few to find the cause: measure at least 4"),
            std::string::npos)
      << check(cell).reason;
}

TEST_F(DriftOfAnExactModel, ACauseThatTooFewPointsSuggestIsSaidToBeUncertain) {
  CalibratedCell cell = reference_.cell;
  cell.robot.joints[2].theta_rad += 0.02 * kRadPerDeg;
  joints_.resize(2);
  const DriftCheck result = check(cell);
  EXPECT_EQ(result.verdict, DriftVerdict::Failed);
  EXPECT_NE(result.reason.find("most likely axis 3's zero moved by 0.0200 deg"), std::string::npos)
      << result.reason;
  EXPECT_NE(result.reason.find(", but 2 points are too few to find the cause: measure at least 4"),
            std::string::npos)
      << result.reason;
}

TEST_F(DriftOfAnExactModel, AChangeThatDoesNoHarmIsAWarning) {
  CalibratedCell cell = reference_.cell;
  cell.base.p_mm.z() += 0.055;  // less than twice the mean error at validation
  const DriftCheck result = check(cell);
  EXPECT_LT(result.probability, kSignificance);
  EXPECT_EQ(result.verdict, DriftVerdict::Warning);
  EXPECT_NE(result.reason.find("a significant but harmless amount"), std::string::npos) << result.reason;
}

TEST_F(DriftOfAnExactModel, AnErrorThatTheModelExpectsOfItselfIsNoProofOfAChange) {
  CalibratedCell cell = reference_.cell;
  cell.base.p_mm.z() += 0.2;
  const ParameterLayout layout = ParameterLayout::of(cell);
  reference_.covariance = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  reference_.covariance(2, 2) = 0.2 * 0.2;
  const DriftCheck result = check(cell);
  EXPECT_GT(result.probability, kSignificance);
  EXPECT_EQ(result.verdict, DriftVerdict::Warning);
  EXPECT_NE(result.reason.find("not known well enough at these poses"), std::string::npos) << result.reason;
}

TEST_F(DriftOfAnExactModel, WithoutAValidationTheModelsOwnExpectationIsTheMeasure) {
  reference_.validation_mean_mm = 0;
  // The mean length of three coordinates of 0.02 mm each is 0.02 sqrt(8 / pi).
  EXPECT_NEAR(check(reference_.cell).reference_mm, 0.0319153824321, 1e-9);
  EXPECT_NEAR(noise_of_mean_error(0.0319153824321).repeatability_mm, 0.02, 1e-9);
}

TEST_F(DriftOfAnExactModel, RefusesNoPointsNumbersThatAreNotFiniteAndANoiseOfZero) {
  EXPECT_FALSE(drift_check(reference_, {}));
  std::vector<Measurement> points = points_of(reference_.cell);
  points[2].p_WS_mm.x() = std::nan("");
  const auto not_finite = drift_check(reference_, points);
  ASSERT_FALSE(not_finite);
  EXPECT_EQ(not_finite.error(), "row 3 holds a number that is not finite");
  reference_.noise = {};
  EXPECT_FALSE(drift_check(reference_, points_of(reference_.cell)));
}

}  // namespace
}  // namespace truepose
