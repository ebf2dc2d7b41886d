// How often a diagnosis names the mistake that was made, on five kinds of arms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/calibrate/calibrate.hpp"
#include "core/diagnosis/model_sanity.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/planted_mistakes.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

using example::Files;
using example::PlantedMistake;

const std::array kArms{example::kr210(), example::ur10(), example::seven_axis(), example::kr210_on_a_rail(),
                       example::scara()};

struct Noise {
  double sigma_mm = 0.02;
  double gross_errors = 0;  ///< part of the points, off by 0.5 to 50 mm
};

/// Links off by up to 3 mm and 15 mrad.
RobotModel off_by_links(RobotModel robot, Random& random) {
  for (Joint& joint : robot.joints) {
    for (double* length : {&joint.a_mm, &joint.d_mm}) *length += random.uniform(-3, 3);
    for (double* angle : {&joint.alpha_rad, &joint.theta_rad, &joint.beta_rad})
      *angle += random.uniform(-0.015, 0.015);
  }
  return robot;
}

Eigen::Vector3d gross_error(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return Eigen::Vector3d{x, y, z}.normalized() * std::exp(random.uniform(std::log(0.5), std::log(50)));
}

/// An arm as it is, what is measured of it to be diagnosed, and fresh points to judge by.
struct Example {
  RobotModel nominal;
  MeasurementData data, fresh;

  Example(const RobotModel& robot, int poses, Noise noise, Random& random) : nominal{robot} {
    const CalibratedCell truth = example::placed(off_by_links(robot, random), random);
    data = example::measured(truth, poses, noise.sigma_mm, random);
    fresh = example::measured(truth, poses, noise.sigma_mm, random);
    for (Measurement& point : data.points) {
      if (random.uniform() < noise.gross_errors) point.p_WS_mm += gross_error(random);
    }
  }
};

/// Mean error of fresh points by the arm that is identified.
double validation_error(const RobotModel& robot, MeasurementData data, const MeasurementData& fresh) {
  for (Measurement point : fresh.points) {
    point.set = PoseSet::Validate;
    data.points.push_back(point);
  }
  const auto result = calibrate(robot, data, {.loss = Loss::Tukey, .check_model = false});
  return result ? result->validate->geometric.mean : 1e9;
}

bool names(const ProbableCause& cause, const std::vector<PlantedMistake>& planted) {
  std::vector<std::string> sentences{cause.sentence};
  for (const ProbableCause& other : cause.others) sentences.push_back(other.sentence);
  return std::ranges::any_of(sentences, [&](const std::string& sentence) {
    return std::ranges::all_of(planted,
                               [&](const PlantedMistake& each) { return sentence.contains(each.words); });
  });
}

struct Tally {
  int planted = 0, named = 0, harmless = 0, fixed = 0, refused = 0, wrong = 0;
};

/// What becomes of mistakes in the files of an example. Mistakes that leave the files as good as right ones
/// need not be named; of two, one may be harmless: then a single fixed one is as good.
void diagnose(const Example& example, std::vector<PlantedMistake> planted, Tally& tally) {
  // A row of a table is mistyped as the table has it, by another convention.
  std::ranges::stable_partition(planted, [](const PlantedMistake& each) {
    return each.kind() == "standard-dh" || each.kind() == "late-rows";
  });
  Files files{example.nominal, example.data}, fresh{example.nominal, example.fresh};
  std::string name;
  for (const PlantedMistake& each : planted) {
    each.make(files);
    each.make(fresh);
    name += each.name + ", ";
  }
  SCOPED_TRACE(example.nominal.name + ", " + name + std::to_string(example.data.points.size()) + " poses");
  ++tally.planted;
  const auto cause = diagnose_files(files.robot, files.data);
  if (cause && names(*cause, planted)) {
    ++tally.named;
    return;
  }
  const double right_mm = validation_error(example.nominal, example.data, example.fresh);
  if (!cause) {
    const double error_mm = validation_error(files.robot, files.data, fresh.data);
    ++(error_mm < 2 * right_mm ? tally.harmless : tally.wrong);
    EXPECT_LT(error_mm, 2 * right_mm) << "nothing is suspected";
    return;
  }
  if (cause->mistakes.empty()) {
    ++tally.refused;
    std::printf("%s %s: %s\n", example.nominal.name.c_str(), name.c_str(), cause->sentence.c_str());
    return;
  }
  ModelAndPoints fixed{files.robot, fresh.data.points, {}};
  for (const Mistake& mistake : cause->mistakes) mistake.apply_fix(fixed);
  const MeasurementData data{files.data.smr_names, cause->fixed_points};
  const double error_mm = validation_error(cause->fixed_arm, data, {data.smr_names, std::move(fixed.points)});
  const bool as_good = error_mm < 2 * right_mm && cause->mistakes.size() < planted.size();
  ++(as_good ? tally.fixed : tally.wrong);
  EXPECT_TRUE(as_good) << in_words(*cause) << " leaves " << error_mm << " mm in place of " << right_mm;
}

void expect_named(const Tally& tally, double share) {
  const int visible = tally.planted - tally.harmless - tally.fixed;
  std::printf("%d planted: %d named, %d harmless, %d named as fewer, %d refused unexplained, %d wrong\n",
              tally.planted, tally.named, tally.harmless, tally.fixed, tally.refused, tally.wrong);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GE(tally.named, share * visible);
}

std::size_t any_of(std::size_t count, Random& random) {
  return static_cast<std::size_t>(random.uniform(0, static_cast<double>(count)));
}

/// Whether two mistakes are not the same number, unit or order of rows twice over.
bool go_together(const PlantedMistake& a, const PlantedMistake& b) {
  const auto group = [](const PlantedMistake& each) {
    const std::string kind = each.kind();
    if (kind == "shifted" || kind.starts_with("missing") || kind == "shuffled") return std::string{"rows"};
    if (kind == "swapped-xyz" || kind == "mirrored") return std::string{"hand"};
    return kind.substr(0, kind.find('-'));
  };
  return group(a) != group(b) && a.kind() != "shuffled" && b.kind() != "shuffled";
}

TEST(DiagnosisStatistics, NamesEachMistakeOnEveryKindOfArm) {
  Random random{1};
  Tally tally;
  for (int trial = 0; trial < trials(1500); ++trial) {
    const RobotModel& robot = kArms[static_cast<std::size_t>(trial) % kArms.size()];
    const int poses = random.uniform() < 0.5 ? 40 : 80;
    const Example example(robot, poses, {}, random);
    const auto mistakes = example::mistakes_of(robot, poses, random.next());
    diagnose(example, {mistakes[static_cast<std::size_t>(trial) / kArms.size() % mistakes.size()]}, tally);
  }
  expect_named(tally, least_rate(0.99));
}

TEST(DiagnosisStatistics, NamesTwoMistakesTogether) {
  Random random{2};
  Tally tally;
  for (int trial = 0; trial < trials(40); ++trial) {
    for (const RobotModel& robot : kArms) {
      const int poses = random.uniform() < 0.5 ? 40 : 80;
      const Example example(robot, poses, {}, random);
      const auto mistakes = example::mistakes_of(robot, poses, random.next());
      const auto [first, second] =
          std::minmax({any_of(mistakes.size(), random), any_of(mistakes.size(), random)});
      const PlantedMistake &one = mistakes[first], &other = mistakes[second];
      if (go_together(one, other)) diagnose(example, {one, other}, tally);
    }
  }
  expect_named(tally, least_rate(0.99));
}

/// Whether a mistake says what is right, and does not concern the order of rows itself.
bool goes_with_any_order(const PlantedMistake& planted) {
  const std::string kind = planted.kind();
  return kind != "zero" && kind != "a" && kind != "d" && !kind.starts_with("missing") && kind != "shifted" &&
         kind != "shuffled";
}

TEST(DiagnosisStatistics, NamesAMistakeTogetherWithRowsInAnotherOrder) {
  Random random{5};
  Tally tally;
  for (int trial = 0; trial < trials(10); ++trial) {
    for (const RobotModel& robot : kArms) {
      const Example example(robot, 60, {}, random);
      const auto mistakes = example::mistakes_of(robot, 60, random.next());
      const PlantedMistake& one = mistakes[any_of(mistakes.size(), random)];
      if (goes_with_any_order(one)) diagnose(example, {one, mistakes.back()}, tally);
    }
  }
  expect_named(tally, least_rate(0.95));
}

TEST(DiagnosisStatistics, NamesTheSameAmongGrossErrorsAndNoise) {
  Random random{3};
  Tally tally;
  for (int trial = 0; trial < trials(100); ++trial) {
    for (const RobotModel& robot : kArms) {
      const Noise noise{.sigma_mm = random.uniform(0.02, 0.2), .gross_errors = random.uniform(0.01, 0.05)};
      const Example example(robot, 60, noise, random);
      const auto mistakes = example::mistakes_of(robot, 60, random.next());
      diagnose(example, {mistakes[any_of(mistakes.size(), random)]}, tally);
    }
  }
  expect_named(tally, least_rate(0.99));
}

TEST(DiagnosisStatistics, AccusesNoRightFile) {
  Random random{4};
  for (int trial = 0; trial < trials(2000); ++trial) {
    for (const RobotModel& robot : kArms) {
      const bool rough = trial % 10 == 0;
      const Noise noise{.sigma_mm = rough ? 0.2 : 0.02, .gross_errors = rough ? 0.05 : 0};
      const int poses = 10 + static_cast<int>(any_of(90, random));
      const Example example(robot, poses, noise, random);
      const auto cause = diagnose_files(robot, example.data);
      EXPECT_FALSE(cause) << "trial " << trial << ", " << robot.name << ", " << poses
                          << " poses: " << in_words(*cause);
    }
  }
}

}  // namespace
}  // namespace truepose
