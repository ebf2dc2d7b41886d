#include "core/diagnosis/model_sanity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/angles.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_paths.hpp"
#include "tests/core/real_arm.hpp"
#include "tests/sanitized.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

constexpr int kShare = TRUEPOSE_SANITIZED ? 10 : 1;  // of the trials

std::string sentence(const std::optional<ProbableCause>& cause) {
  return cause ? cause->sentence : "no cause was found";
}

MeasurementData readings(const RobotModel& real, int poses, Random& random, int reflectors = 1) {
  return example::measured(example::placed(real, random, reflectors), poses, example::kSigma_mm, random);
}

RobotModel with_sign_changed(RobotModel robot, std::size_t joint) {
  robot.joints[joint].sign *= -1;
  return robot;
}

/// Expects `robot` to be refused with the joint named for every joint whose sign is changed.
void expect_every_sign_found(const RobotModel& robot, const MeasurementData& data) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const std::string found = sentence(diagnose_files(with_sign_changed(robot, i), data));
    const std::string joint = "joint " + std::to_string(i + 1);
    EXPECT_TRUE(found.starts_with(joint + " turns the other way") ||
                found.starts_with(joint + " moves the other way"))
        << joint << ": " << found;
  }
}

TEST(ModelSanity, NamesTheJointOfAWrongSignOnEveryArm) {
  Random random{1};
  for (const int poses : {10, 30, 600}) {
    for (int trial = 0; trial < std::max(1, (all_trials() ? 5 : 1) / kShare); ++trial) {
      const RobotModel real = example::with_paper_errors(example::kr210());
      expect_every_sign_found(example::kr210(), readings(real, poses, random));
    }
  }
  for (const RobotModel& nominal : {example::seven_axis(), example::kr210_on_a_rail()}) {
    const RobotModel real = example::deviating(nominal, random, 0.5, 1e-3);
    expect_every_sign_found(nominal, readings(real, 30, random));
  }
}

TEST(ModelSanity, SaysWhichSignWouldBeRightAndWhatItGains) {
  Random random{2};
  const RobotModel real = example::deviating(example::kr210(), random, 0.3, 3e-4);
  const auto cause = diagnose_files(with_sign_changed(example::kr210(), 2), readings(real, 30, random));
  ASSERT_TRUE(cause);
  EXPECT_TRUE(
      cause->sentence.starts_with("joint 3 turns the other way: with sign 1 the coarse error falls from "))
      << cause->sentence;
  EXPECT_GT(cause->error_mm, 100);
  EXPECT_LT(cause->fixed_mm, 5);
}

TEST(ModelSanity, NamesFilesThatAreBothInMetres) {
  Random random{61};
  for (const RobotModel& nominal : {example::kr210(), example::scara()}) {
    MeasurementData data = readings(example::deviating(nominal, random, 0.3, 3e-4), 30, random);
    for (Measurement& point : data.points) point.p_WS_mm /= 1000;
    RobotModel in_metres = nominal;
    for (Joint& joint : in_metres.joints) {
      joint.a_mm /= 1000;
      joint.d_mm /= 1000;
    }
    const auto cause = diagnose_files(in_metres, data);
    ASSERT_TRUE(cause);
    EXPECT_TRUE(cause->sentence.starts_with(
        "the lengths of the robot file and the points are in m, not mm: as they stand the arm reaches no "
        "farther than "))
        << cause->sentence;
    EXPECT_NEAR(cause->fixed_arm.joints[1].a_mm, nominal.joints[1].a_mm, 1e-9);
    EXPECT_EQ(cause->fixed_points[3].p_WS_mm, Eigen::Vector3d{1000 * data.points[3].p_WS_mm});
  }
}

TEST(ModelSanity, NamesARobotFileWithoutLengths) {
  Random random{62};
  const MeasurementData data = readings(example::with_paper_errors(example::kr210()), 30, random);
  RobotModel empty = example::kr210();
  for (Joint& joint : empty.joints) joint.a_mm = joint.d_mm = joint.alpha_rad = 0;
  const auto cause = diagnose_files(empty, data);
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->sentence, "all lengths of the robot file are 0: enter those of the data sheet");
  EXPECT_TRUE(cause->mistakes.empty());
}

TEST(ModelSanity, NamesRadiansTogetherWithMetres) {
  Random random{63};
  MeasurementData data = readings(example::with_paper_errors(example::kr210()), 30, random);
  for (Measurement& point : data.points) {
    point.p_WS_mm /= 1000;
    point.q *= kRadPerDeg;
  }
  EXPECT_THAT(
      sentence(diagnose_files(example::kr210(), data)),
      testing::StartsWith("the joint angles of the measurements are in rad, not deg and the points are "
                          "in m, not mm: with them converted the coarse error falls from"));
  RobotModel in_metres = example::kr210();
  for (Joint& joint : in_metres.joints) {
    joint.a_mm /= 1000;
    joint.d_mm /= 1000;
  }
  EXPECT_THAT(
      sentence(diagnose_files(in_metres, data)),
      testing::StartsWith("the lengths of the robot file and the points are in m, not mm and the joint "
                          "angles of the measurements are in rad, not deg: as they stand"));
}

TEST(ModelSanity, NamesStandardDhTogetherWithRadiansOfTheRobotFile) {
  Random random{64};
  RobotModel robot = example::ur10();
  const MeasurementData data = readings(example::deviating(robot, random, 0.5, 1e-3), 40, random);
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint next = i + 1 < robot.joints.size() ? robot.joints[i + 1] : Joint{};
    robot.joints[i].a_mm = next.a_mm;
    robot.joints[i].alpha_rad = next.alpha_rad * kRadPerDeg;
    robot.joints[i].theta_rad *= kRadPerDeg;
  }
  EXPECT_THAT(
      sentence(diagnose_files(robot, data)),
      testing::StartsWith("the angles of the robot file are in rad, not deg and a and alpha stand one "
                          "row too early, as in standard DH: "));
}

/// How the files of one arm are written.
struct Writing {
  bool is_standard = false, in_metres = false, in_radians = false;  ///< robot file
  bool joints_in_radians = false, points_in_metres = false;
};

RobotModel written(RobotModel robot, const Writing& writing) {
  const std::vector<Joint> modified = robot.joints;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    Joint& joint = robot.joints[i];
    if (writing.is_standard) {
      const Joint next = i + 1 < modified.size() ? modified[i + 1] : Joint{};
      joint.a_mm = next.a_mm;
      joint.alpha_rad = next.alpha_rad;
    }
    if (writing.in_metres) {
      joint.a_mm /= 1000;
      joint.d_mm /= 1000;
    }
    if (writing.in_radians) {
      joint.alpha_rad *= kRadPerDeg;
      joint.theta_rad *= kRadPerDeg;
    }
  }
  return robot;
}

TEST(ModelSanity, DecidesOnUnitsBeforeStructureInAllTheirCombinations) {
  Random random{65};
  const RobotModel nominal = example::ur10();
  const MeasurementData right = readings(example::deviating(nominal, random, 0.4, 5e-4), 60, random);
  std::vector<Writing> writings{
      {.joints_in_radians = true, .points_in_metres = true},
      {.in_metres = true, .in_radians = true, .joints_in_radians = true, .points_in_metres = true},
      {.is_standard = true},
      {.is_standard = true, .joints_in_radians = true},
      {.is_standard = true, .points_in_metres = true},
      {.is_standard = true, .joints_in_radians = true, .points_in_metres = true}};
  for (const bool radians : {false, true}) {
    for (const auto& [q, p] : {std::pair{false, true}, std::pair{true, true}, std::pair{false, false}})
      writings.push_back({true, true, radians, q, p});
  }
  for (const Writing& each : writings) {
    SCOPED_TRACE(testing::Message() << each.is_standard << each.in_metres << each.in_radians
                                    << each.joints_in_radians << each.points_in_metres);
    MeasurementData data = right;
    for (Measurement& point : data.points) {
      if (each.joints_in_radians) point.q *= kRadPerDeg;
      if (each.points_in_metres) point.p_WS_mm /= 1000;
    }
    const auto cause = diagnose_files(written(nominal, each), data);
    const std::string words = sentence(cause);
    EXPECT_EQ(words.contains("standard DH"), each.is_standard) << words;
    EXPECT_EQ(words.contains("the lengths of the robot file"), each.in_metres) << words;
    EXPECT_EQ(words.contains("the angles of the robot file are in rad"), each.in_radians) << words;
    EXPECT_EQ(words.contains("the joint angles of the measurements are in rad"), each.joints_in_radians)
        << words;
    EXPECT_EQ(words.contains("the points are in m") || words.contains("and the points"),
              each.points_in_metres)
        << words;
    EXPECT_FALSE(words.contains("measure") && words.contains("poses")) << words;
    if (!cause) continue;
    EXPECT_EQ(cause->others.size(), 0U) << words;
    for (std::size_t i = 0; i < nominal.joints.size(); ++i)
      EXPECT_NEAR(cause->fixed_arm.joints[i].a_mm, nominal.joints[i].a_mm, 1e-6);
    EXPECT_LT((cause->fixed_points[7].p_WS_mm - right.points[7].p_WS_mm).norm(), 1e-6);
  }
}

TEST(ModelSanity, NeverSuspectsAnArmThatMerelyDeviates) {
  Random random{3};
  for (int trial = 0; trial < (all_trials() ? 200 : 40) / kShare; ++trial) {
    const double times = trial % 2 ? 1 : 3;
    const int poses = std::array{8, 10, 20, 60}[static_cast<std::size_t>(trial / 2 % 4)];
    CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210(), times), random);
    // Down to a reflector right on the last axis, where its sign is hardly identifiable.
    if (trial % 3 == 0) truth.reflectors[0].p_FS_mm.head<2>() *= trial % 6 ? random.uniform() * 0.05 : 0.0;
    const auto cause =
        diagnose_files(example::kr210(), example::measured(truth, poses, example::kSigma_mm, random));
    EXPECT_FALSE(cause) << "trial " << trial << ": " << sentence(cause);
  }
}

TEST(ModelSanity, IsNotMisledByGrossErrorsOrGears) {
  Random random{4};
  for (int trial = 0; trial < 20 / kShare; ++trial) {
    MeasurementData data = readings(example::with_paper_errors(example::kr210()), 60, random);
    for (std::size_t k = 0; k < data.points.size(); k += 20) data.points[k].p_WS_mm.x() += 50;
    data.points[7].p_WS_mm.z() += 1e6;
    EXPECT_FALSE(diagnose_files(example::kr210(), data)) << trial;
  }
  for (int trial = 0; trial < 20 / kShare; ++trial) {
    CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
    truth.reflectors[0].p_FS_mm.head<2>() *= 0.005;
    MeasurementData data = example::measured(truth, 100, example::kSigma_mm, random);
    for (Measurement& point : data.points) {
      JointVector q = point.q;
      for (Eigen::Index i = 0; i < 6; ++i) q[i] += 2e-4 * std::sin(q[i]) + 1e-4 * std::cos(2 * q[i]);
      point.p_WS_mm = truth.predict(q, 0);
    }
    const auto cause = diagnose_files(example::kr210(), data);
    EXPECT_FALSE(cause) << trial << ": " << sentence(cause);
  }
}

TEST(ModelSanity, FindsASignThatShowsOnlyInTheIdentifiedArm) {
  Random random{5};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  truth.reflectors[0].p_FS_mm = {1, 0.5, 100};
  const MeasurementData data = example::measured(truth, 40, example::kSigma_mm, random);
  EXPECT_TRUE(sentence(diagnose_files(with_sign_changed(example::kr210(), 5), data))
                  .starts_with("joint 6 turns the other way: with sign -1 the identified arm's error falls"));
}

TEST(ModelSanity, FindsSignsAndZerosOfAWristWhoseCentreTheReflectorIsNear) {
  Random random{14};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  truth.reflectors[0].p_FS_mm = {1.5, 1, -214};
  const MeasurementData data = example::measured(truth, 60, example::kSigma_mm, random);
  EXPECT_FALSE(diagnose_files(example::kr210(), data));
  for (const std::size_t joint : {3U, 4U, 5U}) {
    const std::string number = std::to_string(joint + 1);
    const auto sign = diagnose_files(with_sign_changed(example::kr210(), joint), data);
    EXPECT_THAT(sign ? in_words(*sign) : "", testing::HasSubstr("joint " + number + " turns the other way"));
  }
  for (const std::size_t joint : {3U, 4U}) {  // what joint 6 stands off by the reflector takes up
    RobotModel robot = example::kr210();
    robot.joints[joint].theta_rad += std::numbers::pi;
    const auto zero = diagnose_files(robot, data);
    EXPECT_THAT(zero ? in_words(*zero) : "",
                testing::HasSubstr("theta of joint " + std::to_string(joint + 1) + " is off by 180 deg"));
  }
}

TEST(ModelSanity, FindsTheUsualMistakesOfARobotFile) {
  Random random{6};
  const RobotModel good = example::kr210();
  const MeasurementData data = readings(example::with_paper_errors(good), 30, random);
  const auto found = [&](auto change) {
    RobotModel wrong = good;
    change(wrong);
    return sentence(diagnose_files(wrong, data));
  };
  constexpr double kRight = std::numbers::pi / 2;
  EXPECT_TRUE(found([](RobotModel& r) {
                r.joints[2].theta_rad += kRight;
              }).starts_with("theta of joint 3 is off by 90 deg: with theta -90 deg the coarse"));
  EXPECT_TRUE(
      found([](RobotModel& r) { r.joints[1].theta_rad += 2 * kRight; }).starts_with("theta of joint 2"));
  EXPECT_TRUE(found([](RobotModel& r) {
                r.joints[3].alpha_rad *= -1;
              }).starts_with("alpha of joint 4 has the wrong sign: with alpha -90 deg"));
  EXPECT_TRUE(found([](RobotModel& r) {
                std::swap(r.joints[3].a_mm, r.joints[3].d_mm);
              }).starts_with("a and d of joint 4 are swapped: with a 115 mm and d 1220 mm"));
  EXPECT_TRUE(found([](RobotModel& r) {
                for (Joint& joint : r.joints) {
                  joint.alpha_rad *= kRadPerDeg;
                  joint.theta_rad *= kRadPerDeg;
                }
              }).starts_with("the angles of the robot file are in rad, not deg"));
  EXPECT_TRUE(found([](RobotModel& r) {
                for (Joint& joint : r.joints) {
                  joint.a_mm /= 1000;
                  joint.d_mm /= 1000;
                }
              }).starts_with("the lengths of the robot file are in m, not mm"));
  EXPECT_TRUE(
      found([](RobotModel& r) {
        r.joints[2].sign *= -1;
        r.joints[2].theta_rad += kRight;
      })
          .starts_with("joint 3 turns the other way and theta of joint 3 is off by 90 deg: with sign 1 and "
                       "theta -90 deg the coarse error falls"));
}

// Axes 2 and 3 are parallel: half of it in the d of each explains the points as well, and what the other
// links of a badly built arm leave is as much with it as without.
TEST(ModelSanity, NamesALengthThatTheNextLinkMakesUpForOnABadlyBuiltArm) {
  const RobotModel good = example::kr210();
  RobotModel wrong = good;
  wrong.joints[1].d_mm += 60;
  for (std::uint64_t seed = 0; seed < 20 / kShare; ++seed) {
    Random random{seed};
    const MeasurementData data = readings(example::deviating(good, random, 2, 9e-3), 60, random);
    const auto cause = diagnose_files(wrong, data);
    EXPECT_TRUE(sentence(cause).starts_with("d of joint 2 is off by "))
        << "seed " << seed << ": " << sentence(cause);
    if (cause) {
      EXPECT_THAT(in_words(*cause), testing::HasSubstr("if d of joint 3 is off by ")) << "seed " << seed;
    }
    EXPECT_FALSE(diagnose_files(good, data)) << "seed " << seed;
  }
}

TEST(ModelSanity, FindsTheUsualMistakesOfAMeasurementFile) {
  Random random{7};
  const RobotModel nominal = example::kr210();
  const MeasurementData good = readings(example::with_paper_errors(nominal), 30, random);
  const auto found = [&](auto change) {
    MeasurementData wrong = good;
    for (Measurement& point : wrong.points) change(point);
    return sentence(diagnose_files(nominal, wrong));
  };
  EXPECT_TRUE(found([](Measurement& m) { m.p_WS_mm /= 1000; }).starts_with("the points are in m, not mm"));
  EXPECT_TRUE(
      found([](Measurement& m) { m.p_WS_mm /= 25.4; }).starts_with("the points are in inches, not mm"));
  EXPECT_TRUE(found([](Measurement& m) {
                m.q *= kRadPerDeg;
              }).starts_with("the joint angles of the measurements are in rad, not deg"));
  EXPECT_TRUE(found([](Measurement& m) {
                std::swap(m.q[1], m.q[4]);
              }).starts_with("the columns q2 and q5 of the measurements are swapped"));
}

TEST(ModelSanity, NamesBothOfWhatTheDataCannotTellApart) {
  Random random{11};
  RobotModel robot = example::kr210();
  robot.joints[0].sign = robot.joints[3].sign = robot.joints[5].sign = 1;
  const auto cause =
      diagnose_files(robot, readings(example::with_paper_errors(example::kr210()), 30, random));
  ASSERT_TRUE(cause);
  EXPECT_THAT(in_words(*cause), testing::HasSubstr("the points are left-handed"));
  EXPECT_THAT(in_words(*cause), testing::HasSubstr("joints 1, 4 and 6 turn the other way"));
}

TEST(ModelSanity, SaysBeforeWhichRowAPointIsMissing) {
  Random random{12};
  MeasurementData data = readings(example::with_paper_errors(example::kr210()), 60, random);
  for (std::size_t k = 24; k + 1 < 60; ++k) data.points[k].p_WS_mm = data.points[k + 1].p_WS_mm;
  data.points.pop_back();
  const auto cause = diagnose_files(example::kr210(), data);
  EXPECT_TRUE(sentence(cause).starts_with(
      "a point is missing before row 25: with the points moved from there on the coarse error falls"))
      << sentence(cause);
  EXPECT_EQ(cause->fixed_points.size(), 58);
}

// The middle miss of all points does not show it.
TEST(ModelSanity, NamesAPointThatIsMissingInTheLastQuarter) {
  Random random{62};
  for (const RobotModel& nominal : {example::kr210(), example::scara(), example::ur10()}) {
    MeasurementData data = readings(example::deviating(nominal, random, 0.5, 1e-3), 40, random);
    for (std::size_t i = 31; i + 1 < data.points.size(); ++i)
      data.points[i].p_WS_mm = data.points[i + 1].p_WS_mm;
    data.points.pop_back();
    EXPECT_THAT(sentence(diagnose_files(nominal, data)),
                testing::StartsWith("a point is missing before row 32: "))
        << nominal.name;
  }
}

TEST(ModelSanity, AccusesNobodyByALineAlongWhichTheFlangeWasHeld) {
  Random random{1008};
  const RobotModel nominal = example::ur10();
  const CalibratedCell truth = example::placed(example::deviating(nominal, random, 0.5, 1e-3), random);
  const auto poses = example::along(nominal, example::Path::Line, 60, 0.01 * kRadPerDeg, random);
  EXPECT_FALSE(diagnose_files(nominal, example::measured(truth, poses, example::kSigma_mm, random)));
}

TEST(ModelSanity, SaysWhereItFailsWhatNothingExplains) {
  Random random{13};
  MeasurementData data = readings(example::with_paper_errors(example::kr210()), 60, random);
  for (Measurement& point : data.points) {
    if (point.q[1] > -60 * kRadPerDeg)
      point.p_WS_mm += 300 * Eigen::Vector3d{random.normal(), random.normal(), random.normal()};
  }
  EXPECT_THAT(sentence(diagnose_files(example::kr210(), data)), testing::HasSubstr("most at joint 2 from "));
}

TEST(ModelSanity, FindsPosesWhoseReflectorsAreMixedUp) {
  Random random{8};
  MeasurementData data = readings(example::with_paper_errors(example::kr210()), 40, random, 3);
  for (std::size_t pose = 5; pose < 20; ++pose)
    std::swap(data.points[3 * pose].smr, data.points[3 * pose + 2].smr);
  const std::string found = sentence(diagnose_files(example::kr210(), data));
  EXPECT_TRUE(
      found.starts_with("the reflectors are mixed up in 15 of 40 poses (first in row 16): with their names "
                        "exchanged the coarse error falls"))
      << found;
}

TEST(ModelSanity, RefusesTheDataOfAnotherArmWithoutGuessing) {
  Random random{9};
  RobotModel other = example::kr210();
  for (Joint& joint : other.joints) joint.a_mm += 300 * random.normal();
  const auto cause = diagnose_files(example::kr210(), readings(other, 30, random));
  ASSERT_TRUE(cause);
  EXPECT_TRUE(cause->sentence.starts_with("the nominal arm misses the points by")) << cause->sentence;
}

TEST(ModelSanity, DoesNotJudgeByFewerThanEightPoses) {
  Random random{10};
  EXPECT_FALSE(diagnose_files(with_sign_changed(example::kr210(), 1), readings(example::kr210(), 7, random)));
}

TEST(ModelSanity, NamesTheJointOfAWrongSignOnARealArm) {
  const auto arm = real_arm();
  if (!arm) GTEST_SKIP() << "no measurements of a real arm";
  const auto& [robot, all] = *arm;
  for (const int poses : {10, 60, 600}) {
    if (poses > 600 / kShare) continue;
    MeasurementData some{all.smr_names, {all.points.begin(), all.points.begin() + 3 * poses}};
    EXPECT_FALSE(diagnose_files(robot, some));
    expect_every_sign_found(robot, some);
  }
  // One reflector alone is 0.4 mm off axis 6: its sign shows only in the identified arm.
  MeasurementData first{{all.smr_names[0]}, {}};
  std::ranges::copy_if(all.points, std::back_inserter(first.points),
                       [](const Measurement& m) { return m.smr == 0; });
  EXPECT_FALSE(diagnose_files(robot, first));
  expect_every_sign_found(robot, first);
}

}  // namespace
}  // namespace truepose
