// How often the drift check is right, over many calibrations, each with its own noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "core/change/drift_check.hpp"
#include "core/change/drift_update.hpp"
#include "core/fit/measured_order.hpp"
#include "core/math/angles.hpp"
#include "core/quality/model_noise.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/core/real_arm.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

constexpr int kPoints = 5;

Eigen::Vector3d any_direction(Random& random) {
  return Eigen::Vector3d::NullaryExpr([&] { return random.normal(); }).normalized();
}

/// What a check judges by, as a model file brings it back.
DriftReference reference_of(const Calibration& calibration, const MeasurementData& data) {
  const MeasurementNoise noise = noise_about_model(calibration, data, std::nullopt);
  return {.cell = calibration.cell,
          .covariance = calibration.covariance,
          .noise = noise,
          .validation_mean_mm = calibration.validate->after.mean,
          .validation_distances2 = validation_distances2(calibration, data, noise)};
}

/// An arm, its calibration, and random numbers for what happens afterwards.
struct CalibratedArm {
  explicit CalibratedArm(std::uint64_t seed) : random{seed + 5000} {
    const SimulatedCampaign campaign = example::campaign(truth, 40, 20, {.seed = seed});
    const auto calibration = calibrate(example::kr210(), campaign.data, {.check_model = false});
    EXPECT_TRUE(calibration);
    if (!calibration) return;
    reference = reference_of(*calibration, campaign.data);
  }

  /// Random poses as the arm stands now.
  std::vector<Measurement> points(int count = kPoints) {
    const auto poses = random_poses(example::kr210(), count, random);
    return measure_campaign(truth, {}, poses, {.seed = random.next()}).data.points;
  }

  TrueArmSetup truth = example::true_arm();
  DriftReference reference;
  Random random;
};

/// Part of `of_all` changed arms, or of a tenth of them, of which `is_right` holds.
template <typename Change, typename IsRight>
double rate(int of_all, Change change, IsRight is_right) {
  const int runs = trials(of_all);
  int right = 0;
  for (int run = 0; run < runs; ++run) {
    CalibratedArm arm(static_cast<std::uint64_t>(run));
    std::vector<Measurement> points = change(arm);
    const auto check = drift_check(arm.reference, points);
    EXPECT_TRUE(check);
    right += check && is_right(*check);
  }
  return static_cast<double>(right) / runs;
}

auto names(const Change& change) {
  return [=](const DriftCheck& check) {
    return !check.causes.empty() && check.causes[0].explains() && check.causes[0].what == change;
  };
}

/// Whether a cause is named, or listed as indistinguishable from the named one.
auto names_or_lists(const Change& change) {
  return [=](const DriftCheck& check) {
    return names(change)(check) || std::ranges::count(check.alternatives, change, &DriftCause::what) > 0;
  };
}

bool noticed(const DriftCheck& check) { return check.verdict != DriftVerdict::Ok; }

std::vector<Measurement> base_moved(CalibratedArm& arm, double way_mm, double turn_rad,
                                    int points = kPoints) {
  arm.truth.X_WB.translation() += way_mm * any_direction(arm.random);
  arm.truth.X_WB.linear() = Eigen::AngleAxisd(turn_rad, any_direction(arm.random)) * arm.truth.X_WB.linear();
  return arm.points(points);
}

TEST(DriftCheckOverManyArms, LeavesUnchangedOnesAloneAtItsStatedLevel) {
  const double ok = rate(
      1000, [](CalibratedArm& arm) { return arm.points(); },
      [](const DriftCheck& check) { return check.verdict == DriftVerdict::Ok; });
  std::cout << "unchanged and ok: " << ok << "\n";
  EXPECT_GE(ok, least_rate(0.97));
}

TEST(DriftCheckOverManyArms, NamesAMovedTrackerOrBase) {
  const double right = rate(
      200, [](CalibratedArm& arm) { return base_moved(arm, 0.2, 0.01 * kRadPerDeg); },
      names({ChangeKind::Base}));
  std::cout << "base named: " << right << "\n";
  EXPECT_GE(right, least_rate(0.95));
}

TEST(DriftCheckOverManyArms, NamesAMovedReflector) {
  const double right = rate(
      200,
      [](CalibratedArm& arm) {
        arm.truth.p_FS_mm += 0.2 * any_direction(arm.random);
        return arm.points();
      },
      names({ChangeKind::Reflector}));
  std::cout << "reflector named: " << right << "\n";
  EXPECT_GE(right, least_rate(0.95));
}

TEST(DriftCheckOverManyArms, NamesTheJointWhoseZeroMoved) {
  // Such angles move the reflector by about 0.2 to 0.5 mm: it is 2 m from axis 1 and 0.1 m from axis 6.
  constexpr std::array kMoved_deg{0.012, 0.012, 0.015, 0.1, 0.1, 0.2};
  for (int joint = 0; joint < 6; ++joint) {
    const auto zero_moved = [&](CalibratedArm& arm) {
      const auto i = static_cast<std::size_t>(joint);
      arm.truth.robot.joints[i].theta_rad += kMoved_deg[i] * kRadPerDeg;
      return arm.points();
    };
    const double named = rate(100, zero_moved, names({ChangeKind::JointZero, joint}));
    const double listed = rate(100, zero_moved, names_or_lists({ChangeKind::JointZero, joint}));
    std::cout << "axis " << joint + 1 << " named: " << named << ", or listed: " << listed << "\n";
    // A reflector that moves explains all that axis 6 does, and now and then the noise a little better.
    EXPECT_GE(named, least_rate(joint == 5 ? 0.88 : 0.95)) << joint + 1;
    EXPECT_GE(listed, least_rate(0.97)) << joint + 1;
  }
}

TEST(DriftCheckOverManyArms, NamesASingleWrongReading) {
  const double right = rate(
      200,
      [](CalibratedArm& arm) {
        std::vector<Measurement> points = arm.points();
        points[2].p_WS_mm += 0.5 * any_direction(arm.random);
        return points;
      },
      names({ChangeKind::Reading, 2}));
  std::cout << "reading named: " << right << "\n";
  EXPECT_GE(right, least_rate(0.95));
}

TEST(DriftCheckOverManyArms, NoticesATrackerThatMovedByMoreTheMoreItMoved) {
  double last = 0;
  for (const double way_mm : {0.02, 0.05, 0.1, 0.2}) {
    const double power = rate(
        200, [&](CalibratedArm& arm) { return base_moved(arm, way_mm, 0); }, noticed);
    std::cout << "a move by " << way_mm << " mm noticed: " << power << "\n";
    EXPECT_GE(power, last);
    last = power;
  }
  EXPECT_GE(last, least_rate(0.99));
}

/// Part of the checks that are not ok, of five random poses each that the calibration has not seen, over
/// random calibrations of a real arm in which nothing changed.
double warned_of_real_arm(const RobotModel& robot, const MeasurementData& arm, bool deviation,
                          double moved_mm = 0) {
  const std::vector<Measurement>& points = arm.points;
  constexpr int kIdentify = 100, kValidate = 40, kChecks = 100;
  const auto poses = static_cast<double>(stops_of(points).size());
  constexpr int kWarmFrom = 600;  // of 1800 rows: until then the arm warms up
  const int runs = trials(20);
  int warned = 0;
  for (int run = 0; run < runs; ++run) {
    Random random(static_cast<std::uint64_t>(run));
    MeasurementData data = arm;
    split_poses(data, (kIdentify + kValidate) / poses, random.next());
    std::vector<Measurement> unseen = points_of(data, PoseSet::Validate);
    std::erase_if(unseen, [](const Measurement& point) { return point.row < kWarmFrom; });
    const std::vector<std::vector<std::size_t>> stops = stops_of(unseen);
    data.points = points_of(data, PoseSet::Identify);
    split_poses(data, static_cast<double>(kIdentify) / (kIdentify + kValidate), random.next());
    const auto calibration = calibrate(robot, data, {.non_geometric = deviation});
    EXPECT_TRUE(calibration);
    if (!calibration) return 1;
    const DriftReference reference = reference_of(*calibration, data);
    for (int check = 0; check < kChecks; ++check) {
      std::vector<Measurement> five;
      for (int i = 0; i < kPoints; ++i)
        for (const std::size_t k : stops[random.next() % stops.size()]) five.push_back(unseen[k]);
      for (Measurement& point : five) point.p_WS_mm.x() += moved_mm;
      warned += drift_check(reference, five)->verdict != DriftVerdict::Ok;
    }
  }
  return static_cast<double>(warned) / (runs * kChecks);
}

TEST(DriftCheckOfARealArm, SeldomWarnsWhereNothingChanged) {
  const auto arm = real_arm();
  if (!arm) GTEST_SKIP() << "no measurements of a real arm";
  MeasurementData one{{"1"}, arm->data.points};
  std::erase_if(one.points, [](const Measurement& point) { return point.smr != 0; });
  const double geometry = warned_of_real_arm(arm->robot, one, false);
  const double deviations = warned_of_real_arm(arm->robot, one, true);
  std::cout << "a real arm warned of: geometry " << geometry << ", with deviations " << deviations << "\n";
  EXPECT_LE(geometry, widened(0.015, 0.02));
  EXPECT_LE(deviations, widened(0.005, 0.005));
}

TEST(DriftCheckOfARealArm, SeldomWarnsOfThreeReflectorsThatShareWhatTheArmDoes) {
  const auto arm = real_arm();
  if (!arm) GTEST_SKIP() << "no measurements of a real arm";
  const double geometry = warned_of_real_arm(arm->robot, arm->data, false);
  const double deviations = warned_of_real_arm(arm->robot, arm->data, true);
  const double moved = warned_of_real_arm(arm->robot, arm->data, true, 0.2);
  std::cout << "a real arm of three reflectors warned of: geometry " << geometry << ", with deviations "
            << deviations << ", moved by 0.2 mm " << moved << "\n";
  EXPECT_LE(geometry, widened(0.015, 0.02));
  EXPECT_LE(deviations, widened(0.005, 0.005));
  EXPECT_GE(moved, widened(0.95, -0.1));
}

TEST(DriftCheckOverManyArms, LeavesUnchangedOnesWithGearsAlone) {
  const int runs = trials(200);
  int warned = 0;
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(run);
    const TrueArmSetup truth = example::true_arm(heavy_arm_errors({.seed = seed}));
    const SimulatedCampaign campaign = example::campaign(truth, 40, 20, {.seed = seed});
    const auto calibration =
        calibrate(example::kr210(), campaign.data, {.non_geometric = true, .check_model = false});
    ASSERT_TRUE(calibration);
    Random random{seed + 5000};
    const auto poses = random_poses(example::kr210(), kPoints, random);
    const SimulatedCampaign now = measure_campaign(truth, {}, poses, {.seed = random.next()});
    warned +=
        drift_check(reference_of(*calibration, campaign.data), now.data.points)->verdict != DriftVerdict::Ok;
  }
  std::cout << "unchanged arms with gears, of " << runs << ", warned of: " << warned << "\n";
  EXPECT_LE(warned, all_trials() ? 2 : 1);
}

/// What an update of many changed arms came to.
struct UpdateTrial {
  double before_mm = 0, after_mm = 0;  ///< mean error at poses that were not measured, of the offered updates
  double within = 0;  ///< share of coordinates there within the 95 % intervals of the new model
  int runs = 0, offered = 0;
};

void judge_updated(const CalibratedArm& arm, const DriftUpdate& update, std::uint64_t seed,
                   UpdateTrial& trial) {
  constexpr int kPoses = 60;
  Random random(seed);
  const auto poses = random_poses(example::kr210(), kPoses, random);
  const SimulatedCampaign elsewhere = measure_campaign(arm.truth, {}, poses, {.seed = seed});
  trial.before_mm += example::mean_miss(arm.reference.cell, elsewhere);
  trial.after_mm += example::mean_miss(update.cell, elsewhere);
  ++trial.offered;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d miss = update.cell.predict(poses[i], 0) - elsewhere.p_true_mm[i];
    const Eigen::Matrix3d C = position_covariance(update.cell, update.covariance, poses[i], 0);
    const auto held = (miss.array().abs() < 1.96 * C.diagonal().array().sqrt()).count();
    trial.within += static_cast<double>(held) / (3 * kPoses);
  }
}

template <typename Change>
UpdateTrial updates(const char* what, Change change) {
  UpdateTrial trial;
  trial.runs = trials(200);
  for (int run = 0; run < trial.runs; ++run) {
    CalibratedArm arm(static_cast<std::uint64_t>(run));
    const std::vector<Measurement> points = change(arm);
    const auto update = update_after_drift(arm.reference, points);
    EXPECT_TRUE(update);
    if (update && update->doubts.empty()) judge_updated(arm, *update, arm.random.next(), trial);
  }
  for (double* mean : {&trial.before_mm, &trial.after_mm, &trial.within}) *mean /= std::max(1, trial.offered);
  std::cout << what << ": seeds 0.." << trial.runs - 1 << ", offered " << trial.offered << ", "
            << trial.before_mm << " -> " << trial.after_mm << " mm, within 95 %: " << trial.within << "\n";
  return trial;
}

/// Of the new models' 95 % intervals.
void expect_honest(const UpdateTrial& trial) {
  EXPECT_GE(trial.within, all_trials() ? 0.93 : 0.9);
  EXPECT_LE(trial.within, all_trials() ? 0.97 : 1.0);
}

void move_zero(CalibratedArm& arm, std::size_t joint, double deg) {
  arm.truth.robot.joints[joint].theta_rad += deg * kRadPerDeg;
}

TEST(DriftUpdateOverManyArms, CorrectsAMovedBaseFromFivePoints) {
  const UpdateTrial trial =
      updates("base", [](CalibratedArm& arm) { return base_moved(arm, 0.2, 0.01 * kRadPerDeg); });
  EXPECT_GE(trial.offered, least_rate(0.97) * trial.runs);
  EXPECT_GT(trial.before_mm, 0.36);
  EXPECT_LE(trial.after_mm, widened(0.048, 0.005));
  expect_honest(trial);
}

TEST(DriftUpdateOverManyArms, CorrectsAMovedJointZeroAndAMovedReflectorFromFivePoints) {
  const UpdateTrial zero = updates("zero", [](CalibratedArm& arm) {
    move_zero(arm, 2, 0.015);
    return arm.points();
  });
  const UpdateTrial reflector = updates("reflector", [](CalibratedArm& arm) {
    arm.truth.p_FS_mm += 0.2 * any_direction(arm.random);
    return arm.points();
  });
  for (const UpdateTrial& trial : {zero, reflector}) {
    EXPECT_GE(trial.offered, least_rate(0.97) * trial.runs);
    EXPECT_LE(trial.after_mm, widened(0.03, 0.004));
    expect_honest(trial);
  }
}

TEST(DriftUpdateOverManyArms, CorrectsBaseZeroAndReflectorAtOnceFromEightPoints) {
  const UpdateTrial trial = updates("all three", [](CalibratedArm& arm) {
    move_zero(arm, arm.random.next() % 6, 0.015);
    arm.truth.p_FS_mm += 0.1 * any_direction(arm.random);
    return base_moved(arm, 0.2, 0.01 * kRadPerDeg, 8);
  });
  EXPECT_GE(trial.offered, least_rate(0.97) * trial.runs);
  EXPECT_LE(trial.after_mm, widened(0.048, 0.005));
  expect_honest(trial);
}

/// @param zero_deg  standard deviation of the ways of the zeros
std::vector<Measurement> warmed_up(CalibratedArm& arm, double zero_deg, double growth) {
  JointVector zero(6);
  for (double& way : zero) way = zero_deg * kRadPerDeg * arm.random.normal();
  arm.truth.robot = warmed(arm.truth.robot, {.zero = zero, .growth = growth}, Seconds{7200});
  return arm.points(20);
}

TEST(DriftUpdateOverManyArms, CorrectsAnArmThatHasWarmedUpFromTwentyPoints) {
  const UpdateTrial trial = updates("warm", [](CalibratedArm& arm) { return warmed_up(arm, 0.006, 30e-6); });
  EXPECT_GE(trial.offered, least_rate(0.97) * trial.runs);
  EXPECT_LE(trial.after_mm, widened(0.02, 0.004));
  expect_honest(trial);
}

TEST(DriftUpdateOverManyArms, IsALittleTooSureOfAnArmThatHasHardlyWarmedUp) {
  const UpdateTrial trial =
      updates("hardly warm", [](CalibratedArm& arm) { return warmed_up(arm, 0.002, 10e-6); });
  EXPECT_LE(trial.after_mm, trial.before_mm / 2);
  EXPECT_GE(trial.within, 0.8);
}

/// Rows of a real arm, some of them repeated as read by encoders with moved zeros.
TEST(DriftUpdateOfARealArm, FindsAllZerosThatMoved) {
  const auto arm = real_arm();
  if (!arm) GTEST_SKIP() << "no measurements of a real arm";
  constexpr std::size_t kRows = 250, kMeasured = 20;
  constexpr std::array kMoved_deg{-0.02, 0.03, -0.025, -0.03, 0.015, -0.04};
  std::vector<Measurement> points = arm->data.points;
  std::erase_if(points, [](const Measurement& point) { return point.smr != 0; });
  points.resize(kRows);
  MeasurementData data{{"1"}, points};
  split_poses(data, 0.7, 1);
  const auto calibration = calibrate(arm->robot, data, {.non_geometric = true, .thermal = ThermalUse::Off});
  ASSERT_TRUE(calibration);
  const DriftReference reference = reference_of(*calibration, data);
  int within = 0;
  const int runs = trials(50);
  for (int run = 0; run < runs; ++run) {
    Random random(static_cast<std::uint64_t>(run));
    std::vector<Measurement> now;
    for (std::size_t i = 0; i < kMeasured; ++i) {
      now.push_back(points[random.next() % kRows]);
      for (Eigen::Index k = 0; k < 6; ++k)
        now.back().q[k] -= kMoved_deg[static_cast<std::size_t>(k)] * kRadPerDeg;
    }
    const auto update = update_after_drift(reference, now);
    ASSERT_TRUE(update);
    EXPECT_TRUE(update->explains) << "seed " << run;
    for (const ChangeFound& move : update->moves) {
      if (move.what.kind != ChangeKind::JointZero) continue;
      const double moved_rad = kMoved_deg[static_cast<std::size_t>(move.what.index)] * kRadPerDeg;
      within += std::abs(move.moved[0] - moved_rad) < 2 * move.sigma[0];
    }
  }
  std::cout << "zeros of a real arm found within two sigma: " << within << " of " << 6 * runs << "\n";
  EXPECT_GE(within, least_rate(0.88) * 6 * runs);
}

TEST(DriftUpdateOverManyArms, CorrectsAWarmerArmFromEightPoints) {
  const UpdateTrial trial = updates("grown", [](CalibratedArm& arm) {
    arm.truth.robot = warmed(arm.truth.robot, {.zero = JointVector::Zero(6), .growth = 60e-6}, Seconds{7200});
    return arm.points(8);
  });
  EXPECT_LE(trial.after_mm, trial.before_mm / 2);
  expect_honest(trial);
}

TEST(DriftUpdateOverManyArms, IsNotOfferedForChanceAWrongReadingOrAnArmThatChangedItself) {
  const UpdateTrial chance = updates("unchanged", [](CalibratedArm& arm) { return arm.points(); });
  const UpdateTrial reading = updates("reading", [](CalibratedArm& arm) {
    std::vector<Measurement> points = arm.points();
    points[2].p_WS_mm += 0.8 * any_direction(arm.random);
    return points;
  });
  const UpdateTrial links = updates("links", [](CalibratedArm& arm) {
    for (Joint& joint : arm.truth.robot.joints) {
      joint.a_mm += 0.3 * arm.random.normal();
      joint.alpha_rad += 3e-4 * arm.random.normal();
    }
    return arm.points();
  });
  const UpdateTrial length = updates("one length", [](CalibratedArm& arm) {
    arm.truth.robot.joints[1 + arm.random.next() % 3].a_mm += 0.3;
    return arm.points(8);
  });
  const UpdateTrial angle = updates("one angle", [](CalibratedArm& arm) {
    arm.truth.robot.joints[1 + arm.random.next() % 3].alpha_rad += 2e-4;
    return arm.points(8);
  });
  for (const UpdateTrial& trial : {chance, reading, links})
    EXPECT_LE(trial.offered, (1 - least_rate(0.98)) * trial.runs);
  for (const UpdateTrial& trial : {length, angle})
    EXPECT_LE(trial.offered, (1 - least_rate(0.95)) * trial.runs);
}

}  // namespace
}  // namespace truepose
