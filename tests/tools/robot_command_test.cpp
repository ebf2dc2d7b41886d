#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// The shipped robot file, and what is measured of an arm with the paper's errors.
class RobotFixCommand : public testing::Test {
 protected:
  RobotFixCommand() {
    const std::string shipped = std::string{TRUEPOSE_SOURCE_DIR} + "/config/robots/kr210_r2700_2.yaml";
    text_ = config::read_text_file(shipped);
    nominal_ = config::load_robot(shipped);
    const CalibratedCell truth{
        published_arm(), {{2500, -300, 400}, {0.1, -0.2, 0.7}}, {{"1", {90, 60, 120}}}};
    Random random{1};
    data_.smr_names = {"1"};
    for (int row = 1; row <= 40; ++row) {
      JointVector q(6);
      for (Eigen::Index i = 0; i < 6; ++i) {
        const Joint& joint = nominal_.joints[static_cast<std::size_t>(i)];
        q[i] = random.uniform(joint.min, joint.max);
      }
      data_.points.push_back({.q = q, .p_WS_mm = truth.predict(q, 0), .row = row});
    }
  }
  std::string with(const std::string& from, const std::string& to) const {
    std::string text = text_;
    return text.replace(text.find(from), from.size(), to);
  }
  std::string robot_file(const std::string& text) { return folder_.write("arm.yaml", text); }
  std::string data_file() {
    std::ostringstream text;
    config::write_measurements(text, data_, nominal_);
    return folder_.write("points.csv", text.str());
  }
  std::string path(const std::string& name) { return folder_.path() / name; }

  TempFolder folder_;
  std::string text_;
  RobotModel nominal_;
  MeasurementData data_;
};

TEST_F(RobotFixCommand, FixesTheLineThatCalibrateNames) {
  const std::string wrong = with("d: 0, theta: -90", "d: 0, theta: 0");
  const std::string robot = robot_file(wrong), data = data_file();
  const Finished refused = run_program("truepose", {"calibrate", "--robot", robot, "--data", data});
  EXPECT_EQ(refused.exit_code, 2);
  const auto lines =
      std::count(wrong.begin(), wrong.begin() + static_cast<std::ptrdiff_t>(wrong.find("a: 1150")), '\n');
  EXPECT_THAT(refused.err,
              StartsWith("truepose: " + robot + ":" + std::to_string(lines + 1) +
                         ":38: joints[3].theta: theta of joint 3 is off by 90 deg: with theta -90 deg the "
                         "coarse error falls from "));
  EXPECT_THAT(refused.err, HasSubstr("; `truepose robot fix` writes it corrected"));

  const Finished fixed = run_program("truepose", {"robot", "fix", robot, data, "--out", path("fixed.yaml")});
  EXPECT_EQ(fixed.exit_code, 0) << fixed.err;
  EXPECT_EQ(config::read_text_file(path("fixed.yaml")), text_);
  EXPECT_THAT(fixed.out, HasSubstr(path("fixed.yaml") + ": written"));
  EXPECT_EQ(
      run_program("truepose", {"calibrate", "--robot", path("fixed.yaml"), "--data", data, "--split", "0.7"})
          .exit_code,
      0);
}

TEST_F(RobotFixCommand, FixesMeasurementsWhereTheMistakeIsInThem) {
  for (Measurement& point : data_.points) point.p_WS_mm /= 1000;
  const std::string robot = robot_file(text_), data = data_file();
  const Finished refused =
      run_program("truepose", {"robot", "fix", robot, data, "--out", path("fixed.yaml")});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, StartsWith("truepose: " + data +
                                      ": x, y, z: the points are in m, not mm: with them "
                                      "converted the coarse error falls"));
  EXPECT_THAT(refused.err, HasSubstr("where --out-data says"));
  EXPECT_FALSE(std::filesystem::exists(path("fixed.yaml")));
  EXPECT_EQ(run_program("truepose", {"robot", "fix", robot, data, "--out-data", path("mm.csv")}).exit_code,
            0);
  EXPECT_EQ(
      run_program("truepose", {"calibrate", "--robot", robot, "--data", path("mm.csv"), "--split", "0.7"})
          .exit_code,
      0);
}

TEST_F(RobotFixCommand, WritesNothingWhereNothingIsWrong) {
  const std::string robot = robot_file(text_), data = data_file();
  const Finished run = run_program("truepose", {"robot", "fix", robot, data, "--out", path("fixed.yaml")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "truepose: " + robot + ": nothing to correct, as far as " + data +
                         " shows: no file was written\n");
  EXPECT_FALSE(std::filesystem::exists(path("fixed.yaml")));
}

}  // namespace
}  // namespace truepose
