#include "core/frames/tool_frame.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <numeric>

#include "core/calibrate/calibrate.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/frames/work_frame.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/frame_errors.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;

constexpr double kTrackerSigma_mm = 0.02;
constexpr double kArmSigma_mm = 0.06 / 3.6161;  // of ISO 9283's RP, per axis

/// A calibrated KR 210 with a tool, and the truth about both, by kinematics of the test's own.
class CalibratedArm {
 public:
  explicit CalibratedArm(std::uint64_t seed, int poses = 30, PriorUse prior = PriorUse::Auto)
      : random_(seed), nominal_(example::kr210()) {
    truth_ = example::placed(example::with_paper_errors(nominal_), random_);
    MeasurementData data{.smr_names = {"1"}};
    for (int i = 0; i < poses; ++i) {
      const JointVector q = joints();
      data.points.push_back({.q = q, .p_WS_mm = seen(q, truth_.reflectors[0].p_FS_mm)});
    }
    const MeasurementNoise noise{.tracker = {.range_mm = kTrackerSigma_mm, .transverse_mm = kTrackerSigma_mm},
                                 .repeatability_mm = kArmSigma_mm};
    const auto calibration = calibrate(nominal_, data, {.prior = prior, .noise = noise});
    by_ = {calibration->cell, calibration->covariance, noise};
    X_FT_ =
        plain::kuka_frame({random_.uniform(-200, 200), random_.uniform(-200, 200), random_.uniform(150, 400)},
                          {random_.uniform(-170, 170), random_.uniform(-80, 80), random_.uniform(-170, 170)});
  }

  /// Where the tracker sees a point of the flange, and where it truly is.
  Eigen::Vector3d seen(const JointVector& q, const Eigen::Vector3d& p_F_mm) {
    return stood(q, p_F_mm) + normal(random_, kTrackerSigma_mm);
  }
  Eigen::Vector3d stood(const JointVector& q, const Eigen::Vector3d& p_F_mm) {
    return truly(q, p_F_mm) + normal(random_, kArmSigma_mm);
  }
  Eigen::Vector3d truly(const JointVector& q, const Eigen::Vector3d& p_F_mm) const {
    return truth_.base.isometry() * plain::moved(plain::flange(truth_.robot, q), p_F_mm);
  }
  /// How the tool's axes truly are in the tracker frame.
  Eigen::Matrix3d turned(const JointVector& q) const {
    return truth_.base.isometry().linear() * (plain::flange(truth_.robot, q) * X_FT_).topLeftCorner<3, 3>();
  }
  Eigen::Vector3d of_tool(const Eigen::Vector3d& p_T_mm) const { return plain::moved(X_FT_, p_T_mm); }
  JointVector joints() {
    while (true) {
      const JointVector q = random_poses(nominal_, 1, random_)[0];
      if (std::abs(q[4]) > 25 * kRadPerDeg) return q;
    }
  }
  /// About a place that all can touch: the TCP comes there from several sides.
  JointVector about(double tilt_deg) {
    const auto tilt = [&] { return random_.uniform(-tilt_deg, tilt_deg) * kRadPerDeg; };
    JointVector q(6);
    q << 0.3 + tilt() / 4, -1.4, 1.6, 0.4 + tilt(), 0.9 + tilt() / 2, 0.2 + tilt();
    return q;
  }
  /// Joints at which the TCP truly stands at a point of the base, to within the arm's repeatability.
  JointVector touching(const Eigen::Vector3d& p_B_mm, const JointVector& near,
                       const Eigen::Vector3d& p_F_mm) {
    const TargetCompensation truly(nominal_, truth_.robot);
    return truly.at_position(p_B_mm + normal(random_, kArmSigma_mm), near, p_F_mm)->q;
  }

  Random& random() { return random_; }
  const RobotModel& nominal() const { return nominal_; }
  const CalibratedCell& truth() const { return truth_; }
  const MeasuringCell& by() const { return by_; }
  const Eigen::Matrix4d& X_FT() const { return X_FT_; }

  /// Errors of the true TCP (mm) and of the tool's true axes (deg) at targets for a frame on the flange,
  /// rounded to KUKA's digits, after compensation.
  struct Errors {
    std::vector<double> mm, deg;
  };
  Errors compensated(const Eigen::Isometry3d& X_FT) {
    const Eigen::Matrix4d tool = plain::kuka_frame(X_FT.translation(), kuka_abc_deg(X_FT.linear()));
    const TargetCompensation compensation(nominal_, by_.cell.robot);
    Errors errors;
    while (errors.mm.size() < 200) {
      const JointVector q = joints();
      const auto solved = compensation.at_joints(q, tool.topRightCorner<3, 1>());
      if (!solved) continue;
      const Eigen::Matrix4d wanted = by_.cell.base.isometry().matrix() * plain::flange(nominal_, q) * tool;
      const Eigen::Matrix4d real =
          truth_.base.isometry().matrix() * plain::flange(truth_.robot, solved->q) * X_FT_;
      errors.mm.push_back(plain::mm_between(real, wanted));
      errors.deg.push_back(plain::rad_between(real, wanted) * kDegPerRad);
    }
    return errors;
  }

 private:
  Random random_;
  RobotModel nominal_;
  CalibratedCell truth_;
  MeasuringCell by_;
  Eigen::Matrix4d X_FT_;
};

const std::vector<FramePoint> kThree{{kOrigin, {}}, {kOnX, {}}, {kInXy, {}}};
const std::vector<Eigen::Vector3d> kThree_mm{{0, 0, 0}, {150, 0, 0}, {30, 150, 0}};

/// Reflectors at origin, x and xy of the tool, each seen in so many orientations.
FrameReadings seen_by_tracker(CalibratedArm& arm, int orientations) {
  FrameReadings data{.points = kThree};
  for (int i = 0; i < orientations; ++i) {
    const JointVector q = arm.joints();
    for (std::size_t k = 0; k < kThree_mm.size(); ++k)
      data.readings.push_back({.point = k, .q = q, .p_WS_mm = arm.seen(q, arm.of_tool(kThree_mm[k]))});
  }
  return data;
}

constexpr double kTurnSigma_rad = 0.01 * kRadPerDeg;

/// A 6-D target at the TCP with the tool's axes, seen in so many orientations.
FrameReadings seen_in_six_dimensions(CalibratedArm& arm, int orientations) {
  FrameReadings data{.points = {{kOrigin, {}}}};
  for (int i = 0; i < orientations; ++i) {
    const JointVector q = arm.joints();
    data.readings.push_back(
        {.q = q,
         .p_WS_mm = arm.seen(q, arm.of_tool({0, 0, 0})),
         .orientation = MeasuredOrientation{rotation_by(normal(arm.random(), kTurnSigma_rad)) * arm.turned(q),
                                            kTurnSigma_rad},
         .row = i + 1});
  }
  return data;
}

/// One fixed point touched by the TCP in so many orientations.
FrameReadings touched(CalibratedArm& arm, int orientations, double tilt_deg) {
  FrameReadings data{.points = {{kOrigin, {}}}};
  const Eigen::Vector3d tcp = arm.of_tool({0, 0, 0});
  const Eigen::Vector3d p_B = plain::moved(plain::flange(arm.truth().robot, arm.about(0)), tcp);
  for (int i = 0; i < orientations; ++i)
    data.readings.push_back({.q = arm.touching(p_B, arm.about(tilt_deg), tcp)});
  return data;
}

TEST(ToolFrame, ReadByTheTrackerInTenOrientationsPutsTheTcpWhereItIsWanted) {
  const int seeds = trials(200);
  std::vector<double> means, as_drawn, turns;
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed));
    const auto tool = tool_frame(seen_by_tracker(arm, 10), arm.by());
    ASSERT_TRUE(tool) << tool.error() << " seed " << seed;
    EXPECT_TRUE(tool->is_sound()) << "seed " << seed;
    const auto errors = arm.compensated(tool->X);
    means.push_back(mean(errors.mm));
    turns.push_back(mean(errors.deg));
    EXPECT_LT(means.back(), 0.12) << "seed " << seed;
    as_drawn.push_back(mean(arm.compensated(Eigen::Isometry3d(arm.X_FT())).mm));
  }
  std::printf("seeds 0..%d: TCP %.4f mm, its axes %.4f deg; of a tool as drawn %.3f mm\n", seeds - 1,
              mean(means), mean(turns), mean(as_drawn));
  EXPECT_LT(mean(means), 0.045);
  EXPECT_LT(mean(turns), 0.03);
  EXPECT_GT(mean(as_drawn), 0.3);
}

TEST(ToolFrame, AFixedPointTouchedInTenOrientationsTellsTheTcpToo) {
  const int seeds = trials(200);
  std::vector<double> means;
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed));
    const auto tool = tool_frame(touched(arm, 10, 60), arm.by());
    ASSERT_TRUE(tool) << tool.error() << " seed " << seed;
    EXPECT_FALSE(tool->is_orientation_known);
    means.push_back(mean(arm.compensated(tool->X).mm));
  }
  std::printf("seeds 0..%d: TCP %.4f mm\n", seeds - 1, mean(means));
  EXPECT_LT(mean(means), 0.045);
}

TEST(ToolFrame, TheStandardDeviationOfTheTcpIsThatOfItsErrors) {
  const int seeds = trials(1000);
  double sum = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed));
    const auto tool = tool_frame(seed % 2 == 0 ? seen_by_tracker(arm, 10) : touched(arm, 10, 60), arm.by());
    ASSERT_TRUE(tool) << tool.error() << " seed " << seed;
    const JointVector q = arm.joints();
    const Eigen::Vector3d p_F_mm = tool->X.translation();
    const Eigen::Vector3d said =
        arm.by().cell.base.isometry() * plain::moved(plain::flange(arm.by().cell.robot, q), p_F_mm);
    const Eigen::Matrix3d C = tcp_covariance(arm.by().cell, arm.by().covariance, q, p_F_mm, &*tool);
    const Eigen::Vector3d error = arm.truly(q, arm.of_tool({0, 0, 0})) - said;
    sum += error.dot(C.inverse() * error) / 3;
  }
  std::printf("seeds 0..%d: mean square of the error over its variance %.3f\n", seeds - 1, sum / seeds);
  EXPECT_NEAR(sum / seeds, 1, widened(0.12, 0.2));
}

TEST(ToolFrame, OneReadingOfA6DTargetTellsTheWholeTool) {
  const int seeds = trials(200);
  std::vector<double> one_mm, one_deg, ten_mm, ten_deg;
  int doubted = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed));
    for (const int readings : {1, 10}) {
      const auto tool = tool_frame(seen_in_six_dimensions(arm, readings), arm.by());
      ASSERT_TRUE(tool) << tool.error() << " seed " << seed;
      EXPECT_TRUE(tool->is_orientation_known) << "seed " << seed;
      if (!tool->is_sound()) std::printf("seed %d, %d readings: doubted without cause\n", seed, readings);
      doubted += !tool->is_sound();
      const auto errors = arm.compensated(tool->X);
      (readings == 1 ? one_mm : ten_mm).push_back(mean(errors.mm));
      (readings == 1 ? one_deg : ten_deg).push_back(mean(errors.deg));
    }
  }
  std::printf("seeds 0..%d: one reading: TCP %.4f mm, its axes %.4f deg; ten: %.4f mm, %.4f deg\n", seeds - 1,
              mean(one_mm), mean(one_deg), mean(ten_mm), mean(ten_deg));
  EXPECT_LE(doubted, seeds / 100);
  EXPECT_LT(mean(one_mm), 0.1);
  EXPECT_LT(mean(one_deg), 0.03);
  EXPECT_LT(mean(ten_mm), 0.045);
  EXPECT_LT(mean(ten_deg), 0.02);
}

TEST(ToolFrame, TheStandardDeviationOfTheToolsTurnIsThatOfItsErrors) {
  const int seeds = trials(1000);
  double sum = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed));
    const auto tool = tool_frame(seen_in_six_dimensions(arm, 1 + seed % 3), arm.by());
    ASSERT_TRUE(tool) << tool.error() << " seed " << seed;
    const JointVector q = arm.joints();
    PointJacobian J;
    const Eigen::Matrix3d R_WF = turn_with_jacobian(arm.by().cell, q, J);
    const Eigen::MatrixXd by_parameters = J + R_WF * tool->by_parameters.bottomRows<3>();
    const Eigen::Matrix3d C = by_parameters * arm.by().covariance * by_parameters.transpose() +
                              R_WF * tool->by_readings.bottomRightCorner<3, 3>() * R_WF.transpose();
    const Eigen::Vector3d error = turn_between(R_WF * tool->X.linear(), arm.turned(q));
    sum += error.dot(C.inverse() * error) / 3;
  }
  std::printf("seeds 0..%d: mean square of the turn over its variance %.3f\n", seeds - 1, sum / seeds);
  EXPECT_NEAR(sum / seeds, 1, widened(0.12, 0.25));
}

TEST(ToolFrame, A6DReadingThatTurnedIsNamedAndOnesOfAnotherFrameAreRefused) {
  CalibratedArm arm(4);
  const FrameReadings right = seen_in_six_dimensions(arm, 8);
  FrameReadings slipped = right;
  slipped.readings[5].orientation->R_WT = rotation_by({0, 0.02, 0}) * slipped.readings[5].orientation->R_WT;
  const auto tool = tool_frame(slipped, arm.by());
  ASSERT_TRUE(tool) << tool.error();
  EXPECT_EQ(tool->doubtful, std::vector<std::size_t>{5});

  FrameReadings inverted = right, some = right, more = right;
  for (FrameReading& reading : inverted.readings) reading.orientation->R_WT.transposeInPlace();
  EXPECT_THAT(tool_frame(inverted, arm.by()).error(), HasSubstr("orientations do not follow the arm"));
  some.readings[2].orientation.reset();
  EXPECT_THAT(tool_frame(some, arm.by()).error(), HasSubstr("some readings have an orientation"));
  more.points.push_back({kOnX, {}});
  more.readings.back().point = 1;
  EXPECT_THAT(tool_frame(more, arm.by()).error(), HasSubstr("gives the whole tool"));
}

TEST(ToolFrame, OrientationsThatAreAlikeAreRefusedWithWhatToDo) {
  CalibratedArm arm(1);
  const auto alike = tool_frame(touched(arm, 10, 3), arm.by());
  ASSERT_FALSE(alike);
  EXPECT_THAT(alike.error(), HasSubstr("touch the point with the tool tilted by 30 deg or more"));
  const auto few = tool_frame(touched(arm, 3, 60), arm.by());
  ASSERT_FALSE(few);
  EXPECT_THAT(few.error(), HasSubstr("in 3 orientations; at least 4"));
}

TEST(ToolFrame, TurnsAboutOneAxisAloneTellNothingAlongIt) {
  CalibratedArm arm(2);
  FrameReadings data = touched(arm, 10, 60);
  for (std::size_t i = 0; i < data.readings.size(); ++i) {
    data.readings[i].q = arm.about(0);
    data.readings[i].q[5] += 0.3 * static_cast<double>(i);
  }
  const auto tool = tool_frame(data, arm.by());
  ASSERT_FALSE(tool);
  EXPECT_THAT(tool.error(), HasSubstr("0.0 deg only"));
}

TEST(ToolFrame, AReadingThatSlippedIsNamed) {
  int named = 0;
  const int seeds = trials(100);
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed));
    FrameReadings data = seen_by_tracker(arm, 10);
    *data.readings[7].p_WS_mm += Eigen::Vector3d(0.2, -0.2, 0.1);
    const auto tool = tool_frame(data, arm.by());
    ASSERT_TRUE(tool) << "seed " << seed;
    named += tool->doubtful == std::vector<std::size_t>{7};
    EXPECT_FALSE(tool->shift && tool->shift->is_real()) << "seed " << seed;
  }
  EXPECT_GE(named, 0.95 * seeds) << "of seeds 0.." << seeds - 1;
}

TEST(ToolFrame, ReadingsThatDoNotBelongTogetherMakeNone) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    CalibratedArm arm(seed);
    const FrameReadings right = seen_by_tracker(arm, 10);
    FrameReadings out_of_step = right, in_degrees = right, turned_wrongly = right;
    for (std::size_t i = 0; i < right.readings.size(); ++i) {
      out_of_step.readings[i].q = right.readings[(i + kThree.size()) % right.readings.size()].q;
      in_degrees.readings[i].q *= kDegPerRad;
      turned_wrongly.readings[i].q[5] *= -1;
    }
    for (const FrameReadings& data : {out_of_step, in_degrees, turned_wrongly}) {
      const auto tool = tool_frame(data, arm.by());
      EXPECT_TRUE(!tool || !tool->is_sound()) << "seed " << seed;
    }
    // A hand that touches ten times worse than the arm comes back makes a tool, whose sigma knows it.
    FrameReadings by_hand = right;
    for (FrameReading& reading : by_hand.readings) *reading.p_WS_mm += normal(arm.random(), 0.12);
    const auto tool = tool_frame(by_hand, arm.by());
    ASSERT_TRUE(tool) << tool.error();
    EXPECT_TRUE(tool->is_sound()) << "seed " << seed;
  }
}

/// One reflector at the TCP, seen in ten orientations as far apart as a tracker may allow.
FrameReadings seen_from_one_side(CalibratedArm& arm) {
  FrameReadings data{.points = {{kOrigin, {}}}};
  for (int i = 0; i < 10; ++i) {
    const JointVector q = arm.about(25);
    data.readings.push_back({.q = q, .p_WS_mm = arm.seen(q, arm.of_tool({0, 0, 0}))});
  }
  return data;
}

// A TCP without it would be as far off.
TEST(ToolFrame, ATrackerThatMovedSinceTheModelWasMadeIsReported) {
  const int seeds = trials(1000);
  int reported = 0, false_alarms = 0;
  double square = 0, unseen_mm = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed));
    FrameReadings data = seen_from_one_side(arm);
    const auto sound = tool_frame(data, arm.by());
    ASSERT_TRUE(sound && sound->shift) << "seed " << seed;
    false_alarms += sound->shift->is_real();
    const Eigen::Matrix3d information = sound->shift->covariance.inverse();
    square += sound->shift->p_B_mm.dot(information * sound->shift->p_B_mm) / 3;
    unseen_mm += sound->shift->unseen_mm() / seeds;

    // Along the beam, where it hides best, and the flange's direction is turned least.
    const Eigen::Vector3d beam = data.readings[0].p_WS_mm->normalized();
    for (FrameReading& reading : data.readings) *reading.p_WS_mm += 0.5 * beam;
    const auto moved = tool_frame(data, arm.by());
    ASSERT_TRUE(moved && moved->shift) << "seed " << seed;
    reported += moved->shift->is_real() && !moved->is_sound();
    const Eigen::Vector3d moved_by = -0.5 * (arm.by().cell.base.isometry().linear().transpose() * beam);
    const Eigen::Vector3d error = moved->shift->p_B_mm - sound->shift->p_B_mm - moved_by;
    EXPECT_LT(error.norm(), 0.05) << "seed " << seed;
  }
  std::printf(
      "seeds 0..%d: 0.5 mm reported in %d, unseen up to %.2f mm; nothing moved: reported in %d, square over variance %.3f\n",
      seeds - 1, reported, unseen_mm, false_alarms, square / seeds);
  EXPECT_EQ(false_alarms, 0);
  EXPECT_GE(reported, 0.99 * seeds);
  EXPECT_NEAR(square / seeds, 1, widened(0.12, 0.2));
}

TEST(ToolFrame, AnglesAreRightWhereKukasBIsNinety) {
  for (const double b : {90.0, -90.0}) {
    const Eigen::Matrix4d X = plain::kuka_frame({10, 20, 300}, {40, b, -25});
    const Eigen::Vector3d abc = kuka_abc_deg(X.topLeftCorner<3, 3>());
    EXPECT_LT((plain::kuka_frame({10, 20, 300}, abc) - X).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(abc[1], b, 1e-6);
  }
}

/// The work frame's points touched with the measured tool, each so often.
FrameReadings touched_points(CalibratedArm& arm, const Eigen::Matrix4d& X_BU, std::vector<FramePoint> points,
                             const std::vector<Eigen::Vector3d>& p_U_mm, int times) {
  FrameReadings data{.points = std::move(points)};
  for (std::size_t k = 0; k < p_U_mm.size(); ++k) {
    for (int i = 0; i < times; ++i) {
      const Eigen::Vector3d p_B = plain::moved(X_BU, p_U_mm[k]);
      data.readings.push_back({.point = k, .q = arm.touching(p_B, arm.about(30), arm.of_tool({0, 0, 0}))});
    }
  }
  return data;
}

/// How far the origins of measured frames are off.
struct OriginErrors {
  double worst_mm = 0;
  double mean_square = 0;  ///< over the stated variance
};

/// @param poses  by which the arm was calibrated
void find_frames(int poses, PriorUse prior, OriginErrors& errors) {
  const std::vector<Eigen::Vector3d> corners{{0, 0, 0}, {600, 0, 0}, {0, 400, 0}, {600, 400, 50}};
  const std::vector<FramePoint> known{
      {"a", corners[0]}, {"b", corners[1]}, {"c", corners[2]}, {"d", corners[3]}};
  const int seeds = trials(200);
  for (int seed = 0; seed < seeds; ++seed) {
    CalibratedArm arm(static_cast<std::uint64_t>(seed), poses, prior);
    const auto tool = tool_frame(seen_by_tracker(arm, 10), arm.by());
    ASSERT_TRUE(tool);
    const TouchingTool tcp{tool->X.translation(), &*tool};
    const Eigen::Matrix4d X_BU = plain::kuka_frame({1500, 200, 600}, {30, 2, -1});
    const auto by_three = work_frame(touched_points(arm, X_BU, kThree, kThree_mm, 3), arm.by(), tcp);
    const auto by_known = work_frame(touched_points(arm, X_BU, known, corners, 2), arm.by(), tcp);
    ASSERT_TRUE(by_three && by_known) << "seed " << seed;
    // Both bases are the arm's own: the tracker's view of the true one tells them apart.
    const Eigen::Matrix4d wanted =
        arm.by().cell.base.isometry().inverse().matrix() * arm.truth().base.isometry().matrix() * X_BU;
    for (const auto* frame : {&*by_three, &*by_known}) {
      const Eigen::Vector3d error = frame->X.translation() - wanted.topRightCorner<3, 1>();
      errors.worst_mm = std::max(errors.worst_mm, error.norm());
      errors.mean_square += error.squaredNorm() / (frame->sigma_mm() * frame->sigma_mm()) / (2.0 * seeds);
    }
    EXPECT_EQ(by_known->misfit_mm.size(), 4U);
  }
  std::printf("%d poses, seeds 0..%d: worst origin %.3f mm off, mean square over its variance %.2f\n", poses,
              seeds - 1, errors.worst_mm, errors.mean_square);
}

TEST(WorkFrame, IsWhereTheArmPutsItsTcpWithTheStatedSigma) {
  OriginErrors errors;
  find_frames(30, PriorUse::Auto, errors);
  EXPECT_LT(errors.worst_mm, 0.3);
  EXPECT_LT(errors.mean_square, 2);
}

// A prior leaves open what is the base's and what link 1's: that is no error of a frame.
TEST(WorkFrame, TellsItsSigmaWhereThePriorIsNeededToo) {
  for (const int poses : {9, 16}) {
    OriginErrors errors;
    find_frames(poses, PriorUse::On, errors);
    EXPECT_LT(errors.mean_square, 2);
    EXPECT_GT(errors.mean_square, 0.4);
  }
}

TEST(WorkFrame, KnowsWhatWrongCoordinatesOfItsPointsCost) {
  const std::vector<Eigen::Vector3d> corners{{0, 0, 0}, {600, 0, 0}, {0, 400, 0}, {600, 400, 50}};
  std::vector<FramePoint> stated;
  for (const Eigen::Vector3d& corner : corners)
    stated.push_back({"p" + std::to_string(stated.size()), corner});
  *stated[2].p_mm += Eigen::Vector3d(0, 0, 1);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    CalibratedArm arm(seed);
    const Eigen::Matrix4d X_BU = plain::kuka_frame({1500, 200, 600}, {30, 2, -1});
    const auto frame = work_frame(touched_points(arm, X_BU, stated, corners, 3), arm.by(),
                                  {arm.of_tool({0, 0, 0}), nullptr});
    ASSERT_TRUE(frame) << frame.error();
    EXPECT_NEAR(frame->coordinates_off_mm, 0.3, 0.15) << "seed " << seed;
    const Eigen::Matrix4d wanted =
        arm.by().cell.base.isometry().inverse().matrix() * arm.truth().base.isometry().matrix() * X_BU;
    EXPECT_LT(plain::rad_between(frame->X.matrix(), wanted), 3 * frame->sigma_rad()) << "seed " << seed;
  }
}

TEST(WorkFrame, PointsThatAreSwappedAreNotAFrame) {
  CalibratedArm arm(3);
  const Eigen::Matrix4d X_BU = plain::kuka_frame({1500, 200, 600}, {30, 2, -1});
  const std::vector<Eigen::Vector3d> corners{{0, 0, 0}, {600, 0, 0}, {0, 400, 0}};
  const auto frame = work_frame(
      touched_points(arm, X_BU, {{"a", corners[1]}, {"b", corners[0]}, {"c", corners[2]}}, corners, 1),
      arm.by(), {arm.of_tool({0, 0, 0}), nullptr});
  ASSERT_FALSE(frame);
  EXPECT_THAT(frame.error(), HasSubstr("swapped"));
}

}  // namespace
}  // namespace truepose
