// The shipped robot files against published transformations. The oracle multiplies these in plain numbers and
// shares no code with the product.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "config/robot_file.hpp"
#include "config/robot_text.hpp"
#include "core/arm/forward.hpp"
#include "core/math/random.hpp"

namespace truepose::config {
namespace {

const std::filesystem::path kShippedArms = TRUEPOSE_SOURCE_DIR "/config/robots";

/// Row major, mm.
using Matrix = std::array<std::array<double, 4>, 4>;

constexpr Matrix kIdentity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};

Matrix times(const Matrix& A, const Matrix& B) {
  Matrix C{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) C[i][j] += A[i][k] * B[k][j];
  return C;
}

Matrix inverse(const Matrix& A) {
  Matrix B = kIdentity;
  for (std::size_t i = 0; i < 3; ++i) {
    B[i][3] = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      B[i][j] = A[j][i];
      B[i][3] -= A[j][i] * A[j][3];
    }
  }
  return B;
}

/// Rodrigues' formula.
Matrix turn_about(double x, double y, double z, double rad) {
  const double c = std::cos(rad), s = std::sin(rad), v = 1 - c;
  return {{{x * x * v + c, x * y * v - z * s, x * z * v + y * s, 0},
           {x * y * v + z * s, y * y * v + c, y * z * v - x * s, 0},
           {x * z * v - y * s, y * z * v + x * s, z * z * v + c, 0},
           {0, 0, 0, 1}}};
}
Matrix shift_by(double x, double y, double z) {
  return {{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}, {0, 0, 0, 1}}};
}

/// x y z (m) and roll pitch yaw.
Matrix origin(const std::vector<double>& n) {
  const Matrix turn =
      times(turn_about(0, 0, 1, n[5]), times(turn_about(0, 1, 0, n[4]), turn_about(1, 0, 0, n[3])));
  return times(shift_by(n[0] * 1000, n[1] * 1000, n[2] * 1000), turn);
}

struct Step {
  std::string kind, type;
  std::vector<double> numbers;
};
struct PublishedArm {
  std::vector<Step> steps;
  std::vector<std::array<double, 3>> coupled;  // joint, to, factor
};

std::map<std::string, PublishedArm> published_arms() {
  std::map<std::string, PublishedArm> arms;
  std::ifstream file{TRUEPOSE_SOURCE_DIR "/tests/config/published_arms.txt"};
  PublishedArm* arm = nullptr;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words{line};
    Step step;
    if (line.starts_with('#') || !(words >> step.kind)) continue;
    if (step.kind == "arm") {
      words >> step.type;
      arm = &arms[step.type];
      continue;
    }
    if (step.kind == "row") words >> step.type;
    for (double number = 0; words >> number;) step.numbers.push_back(number);
    if (step.kind == "coupled") {
      arm->coupled.push_back({step.numbers.at(0), step.numbers.at(1), step.numbers.at(2)});
    } else {
      arm->steps.push_back(step);
    }
  }
  return arms;
}

Matrix flange_of(const PublishedArm& arm, std::vector<double> q) {
  const std::vector<double> shown = q;
  for (const auto& [joint, to, factor] : arm.coupled)
    q.at(static_cast<std::size_t>(joint) - 1) += factor * shown.at(static_cast<std::size_t>(to) - 1);
  Matrix T = kIdentity;
  std::size_t next = 0;
  for (const Step& step : arm.steps) {
    const std::vector<double>& n = step.numbers;
    if (step.kind == "fixed") {
      T = times(T, origin(n));
    } else if (step.kind == "inverse") {
      T = times(T, inverse(origin(n)));
    } else if (step.kind == "row") {
      const double value = n.at(4) * q.at(next++), rad = std::acos(-1.0) / 180;
      const bool slides = step.type == "prismatic";
      T = times(T, times(turn_about(1, 0, 0, n[1] * rad), shift_by(n[0], 0, 0)));
      T = times(T, times(turn_about(0, 0, 1, n[3] * rad + (slides ? 0 : value)),
                         shift_by(0, 0, n[2] + (slides ? value : 0))));
    } else {
      T = times(T, origin(n));
      const double value = q.at(next++);
      T = times(T, step.kind == "prismatic" ? shift_by(n[6] * value, n[7] * value, n[8] * value)
                                            : turn_about(n.at(6), n.at(7), n.at(8), value));
    }
  }
  return T;
}

struct Miss {
  double mm = 0, of_axes = 0;
};

/// The largest differences at 200 positions within the limits.
Miss largest_miss(const RobotModel& robot, const PublishedArm& arm) {
  Random random{48};
  Miss miss;
  for (int i = 0; i < 200; ++i) {
    JointVector q(robot.joint_count());
    std::vector<double> values;
    for (int j = 0; j < robot.joint_count(); ++j) {
      const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
      values.push_back(q[j] = random.uniform(joint.min, joint.max));
    }
    const Matrix expected = flange_of(arm, values);
    const Eigen::Isometry3d X = forward_kinematics(robot, q);
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 4; ++column) {
        const double difference = std::abs(
            X(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) - expected[row][column]);
        double& largest = column == 3 ? miss.mm : miss.of_axes;
        largest = std::max(largest, difference);
      }
    }
  }
  return miss;
}

class PublishedArms : public testing::TestWithParam<std::string> {};

TEST_P(PublishedArms, StandWhereTheirSourceSaysWithinAHundredthOfAMillimetre) {
  const std::map<std::string, PublishedArm> published = published_arms();
  ASSERT_TRUE(published.contains(GetParam())) << "no published source in published_arms.txt";
  const RobotModel robot = load_robot(kShippedArms / (GetParam() + ".yaml"));
  const Miss miss = largest_miss(robot, published.at(GetParam()));
  EXPECT_LT(miss.mm, 0.01);
  EXPECT_LT(miss.of_axes, 1e-5);
  RecordProperty("largest_mm", std::to_string(miss.mm));
}

TEST_P(PublishedArms, ReadBackFromTheirTextAsTheyWere) {
  RobotModel robot = load_robot(kShippedArms / (GetParam() + ".yaml"));
  robot.payload.reset();
  const std::string text = robot_text(robot, {"a comment"});
  EXPECT_EQ(text.substr(0, 12), "# a comment\n");
  const RobotModel again = parse_robot(text, "again.yaml");
  EXPECT_EQ(again.name, robot.name);
  EXPECT_EQ(again.masses, robot.masses);
  EXPECT_EQ(robot_text(again, {"a comment"}), text);
  Random random{1};
  for (int i = 0; i < 20; ++i) {
    JointVector q(robot.joint_count());
    for (double& each : q) each = random.uniform(-3, 3);
    EXPECT_LT(
        (forward_kinematics(again, q).translation() - forward_kinematics(robot, q).translation()).norm(),
        1e-9);
  }
}

std::vector<std::string> shipped_arms() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator{kShippedArms})
    names.push_back(entry.path().stem());
  std::ranges::sort(names);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Shipped, PublishedArms, testing::ValuesIn(shipped_arms()),
                         [](const auto& shipped) { return shipped.param; });

TEST(ShippedArms, NameTheirSourceInAComment) {
  EXPECT_GE(shipped_arms().size(), 25u);
  for (const std::string& name : shipped_arms()) {
    std::ifstream file{kShippedArms / (name + ".yaml")};
    const std::string text{std::istreambuf_iterator<char>{file}, {}};
    EXPECT_NE(text.find("# Source: "), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace truepose::config
