#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// The shipped robot file, and what is measured of an arm with the paper's errors.
class RobotFixCommand : public testing::Test {
 protected:
  RobotFixCommand() {
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
  std::string data_file() {
    std::ostringstream text;
    config::write_measurements(text, data_, nominal_);
    return folder_.write("points.csv", text.str());
  }
  std::string path(const std::string& name) { return folder_.path() / name; }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
  MeasurementData data_;
};

TEST_F(RobotFixCommand, FixesMeasurementsWhereTheMistakeIsInThem) {
  for (Measurement& point : data_.points) point.p_WS_mm /= 1000;
  const std::string robot = kRobot, data = data_file();
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

TEST_F(RobotFixCommand, WritesNothingWhereTwoCorrectionsFitEquallyUntilOneIsChosen) {
  const std::string data = data_file(), fixed = path("fixed.yaml");
  std::string text = config::read_text_file(kRobot);
  const auto sign = text.find("sign: -1");
  const std::string wrong = folder_.write("wrong.yaml", text.replace(sign, 8, "sign: 1"));
  const Finished refused = run_program("truepose", {"robot", "fix", wrong, data, "--out", fixed});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err,
              HasSubstr("wrong.yaml: 2 corrections fit equally: (1) joint 1 turns the other way"));
  EXPECT_THAT(refused.err, HasSubstr("(2) alpha of joint 2 has the wrong sign"));
  EXPECT_THAT(refused.err, HasSubstr("No file was written. Choose one: --take 1 .. --take 2"));
  EXPECT_FALSE(std::filesystem::exists(fixed));
  const Finished beyond =
      run_program("truepose", {"robot", "fix", wrong, data, "--out", fixed, "--take", "3"});
  EXPECT_EQ(beyond.exit_code, 1);
  EXPECT_THAT(beyond.err, HasSubstr("--take 3: there are 2 corrections: no file was written"));
  EXPECT_EQ(run_program("truepose", {"robot", "fix", wrong, data, "--out", fixed, "--take", "2"}).exit_code,
            0);
  EXPECT_GT(config::load_robot(fixed).joints[1].alpha_rad, 0);
}

TEST_F(RobotFixCommand, DataCheckShowsWhatAFileIsUnderstoodAs) {
  const std::string data = folder_.write("teach.csv",
                                         "Zelle 4\nA1;A2;A3;A4;A5;A6;X [mm];Y [mm];Z [mm]\n"
                                         "10,5;-90,0;90,0;0,0;0,0;0,0;1500,25;10,5;2000\n"
                                         "20,5;-80,0;90,0;0,0;0,0;400,0;1400,25;10,5;2000\n"
                                         "10,5;-90,0;90,0;0,0;0,0;0,0;1500,25;10,5;2000\n"
                                         "30,5;-90,0;90,0;0,0;0,0;0,0;91500,25;10,5;2000\n");
  const Finished check = run_program("truepose", {"data", "check", data, "--robot", kRobot});
  EXPECT_EQ(check.exit_code, 1);
  EXPECT_EQ(check.err, data +
                           ": read as: semicolons; header in line 2; decimal commas; q1..q6 from 'A1'..'A6', "
                           "x from 'X [mm]', y from 'Y [mm]', z from 'Z [mm]'\n");
  EXPECT_THAT(check.out, HasSubstr("4 rows, the first ones"));
  EXPECT_THAT(check.out, HasSubstr("\nq1      10.5"));
  EXPECT_THAT(check.out, HasSubstr("row 3: the same numbers as in a row before"));
  EXPECT_THAT(check.out,
              HasSubstr("joints have 1 decimal: rounding to 0.1 deg moves a point at 2 m by up to 1.7 mm"));
  EXPECT_THAT(check.out, HasSubstr("row 4: beyond the arm's reach"));
  EXPECT_THAT(check.out, HasSubstr("row 2: q6 is beyond its limits (-350..350 deg)"));
  const Finished right = run_program("truepose", {"data", "check", data_file(), "--robot", kRobot, "--json"});
  EXPECT_EQ(right.exit_code, 0) << right.out;
  EXPECT_THAT(right.out, HasSubstr("\"rows\":40"));
}

}  // namespace
}  // namespace truepose
