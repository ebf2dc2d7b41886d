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

TEST_F(RobotFixCommand, DataCheckShowsJointsAndPointsOfTwoFiles) {
  const std::string joints = folder_.write("joints.csv",
                                           "point,A1,A2,A3,A4,A5,A6\n"
                                           "P1,0,-90,90,0,10,0\nP2,10,-80,90,0,20,0\n");
  const std::string points =
      folder_.write("points.csv", "Name;X;Y;Z\nP2;1600,5;5;1900\nP1;1500,1;0,2;2000\n");
  for (const std::string& two : {joints + "+" + points, points + "+" + joints}) {
    const Finished check = run_program("truepose", {"data", "check", two, "--robot", kRobot});
    EXPECT_THAT(check.err, HasSubstr("joints of " + joints + " by 'point', points of " + points +
                                     " by 'Name': 2 joined"));
    EXPECT_THAT(check.out,
                HasSubstr("joints have 0 decimals: rounding to 1 deg moves a point at 2 m by up to 17.5 mm"));
    EXPECT_THAT(check.out, HasSubstr("\nP2     10  -80  90  0   20  0   1600.5  5    1900\n"));
  }
}

/// A robot command in a folder of its own.
class RobotCommands : public testing::Test {
 protected:
  std::string path(const std::string& name) { return folder_.path() / name; }
  TempFolder folder_;
};

constexpr char kTableOfUr10[] =
    "a,alpha,d,theta\n0,90,127.3,0\n-612,0,0,0\n-572.3,0,0,0\n0,90,163.941,0\n0,-90,115.7,0\n0,0,92.2,0\n";
constexpr char kShownJoints[] =
    "q1,q2,q3,q4,q5,q6\n0,-90,90,0,0,0\n30,-70,60,20,40,10\n-50,-100,110,-60,-30,80\n";

TEST_F(RobotCommands, ImportWritesARobotFileAndPrintsThreePosesToCompare) {
  const std::string table = folder_.write("ur10.csv", kTableOfUr10);
  const Finished run = run_program("truepose", {"robot", "import", table, "--dh", "standard", "--units",
                                                "mm,deg", "--name", "UR10", "--out", path("arm.yaml")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr(path("arm.yaml") + ": UR10, 6 joints, written"));
  EXPECT_THAT(run.out, HasSubstr("  q 0, 0, 0, 0, 0, 0: x -1184.300 y -256.141 z 11.600 mm"));
  EXPECT_THAT(run.out, HasSubstr("no limits or speeds in the table: enter those of the data sheet"));
  EXPECT_THAT(text_of(path("arm.yaml")), StartsWith("# UR10, imported from ur10.csv\n"));
  const RobotModel robot = config::load_robot(path("arm.yaml"));
  EXPECT_EQ(robot.joints[2].a_mm, -612);
}

TEST_F(RobotCommands, ImportAsksWhereASourceLeavesAChoice) {
  const std::string table = folder_.write("ur10.csv", kTableOfUr10), text = folder_.write("arm.txt", "");
  const auto error = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"robot", "import"});
    words.insert(words.end(), {"--out", path("arm.yaml")});
    const Finished run = run_program("truepose", words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    return run.err;
  };
  EXPECT_THAT(error({table}), HasSubstr("which convention has this table? Give --dh standard"));
  EXPECT_THAT(error({table, "--dh", "modified"}), HasSubstr("no unit is said"));
  EXPECT_THAT(error({table, "--dh", "modified", "--units", "mm"}),
              HasSubstr("--units: expected a length and an angle"));
  EXPECT_THAT(error({table, "--dh", "standard", "--units", "mm,deg", "--coupling", "2,3,1"}),
              HasSubstr("--coupling: expected a joint, one before it"));
  EXPECT_THAT(error({text}), HasSubstr("not a kind of file that can be imported"));
  EXPECT_FALSE(std::filesystem::exists(path("arm.yaml")));
}

TEST_F(RobotCommands, ImportRefusesNumbersThatNoArmHas) {
  const std::string table = folder_.write("ur10.csv", kTableOfUr10);
  const auto error = [&](const std::string& units) {
    const Finished run = run_program("truepose", {"robot", "import", table, "--dh", "standard", "--units",
                                                  units, "--out", path("arm.yaml")});
    EXPECT_EQ(run.exit_code, 2) << run.out;
    return run.err;
  };
  EXPECT_THAT(error("m,deg"),
              HasSubstr("ur10.csv: joint 1: d is 127300 mm (limit 20000). Correct the unit in "
                        "the source, or --units."));
  EXPECT_THAT(error("mm,rad"), HasSubstr("joint 2: alpha is 5157 deg (limit 720)"));
  EXPECT_FALSE(std::filesystem::exists(path("arm.yaml")));
}

TEST_F(RobotCommands, ImportOfAFanucWithoutItsCouplingWarns) {
  const std::string arm = folder_.write(
      "arm.urdf",
      "<robot name='fanuc_test'><link name='base'/><link name='a'/><link name='b'/><link name='tool0'/>"
      "<joint name='j1' type='revolute'><parent link='base'/><child link='a'/><axis xyz='0 0 1'/>"
      "<limit lower='-1' upper='1' velocity='1'/></joint>"
      "<joint name='j2' type='revolute'><origin xyz='0.1 0 0.4'/><parent link='a'/><child link='b'/><axis xyz='0 1 0'/>"
      "<limit lower='-1' upper='1' velocity='1'/></joint>"
      "<joint name='j3' type='revolute'><origin xyz='0 0 0.5'/><parent link='b'/><child link='tool0'/><axis xyz='0 -1 0'/>"
      "<limit lower='-1' upper='1' velocity='1'/></joint></robot>");
  const char* const warning =
      "FANUC: joint 3 of the controller moves with joint 2, and here it does not: give --coupling 3,2,1";
  const std::vector<std::string> import{"robot", "import", arm, "--out", path("arm.yaml")};
  EXPECT_THAT(run_program("truepose", import).out, HasSubstr(warning));
  EXPECT_THAT(text_of(path("arm.yaml")), HasSubstr(warning));
  std::vector<std::string> coupled = import;
  coupled.insert(coupled.end(), {"--coupling", "3,2,1"});
  EXPECT_THAT(run_program("truepose", coupled).out, testing::Not(HasSubstr("FANUC:")));
}

TEST_F(RobotCommands, ListShowAndNewSayWhichRobotsThereAre) {
  const Finished list = run_program("truepose", {"robot", "list"});
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.out, HasSubstr("\nkr210_r2700_2 "));
  const Finished shown = run_program("truepose", {"robot", "show", "m20ia"});
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_THAT(shown.out, HasSubstr("m20ia.yaml: FANUC M-20iA\n"));
  EXPECT_THAT(shown.out, HasSubstr("coupling {joint: 3, to: 2, factor: 1}"));
  const Finished unknown = run_program("truepose", {"robot", "show", "m20ib"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean 'm20ia'?"));
  EXPECT_EQ(
      run_program("truepose", {"robot", "new", "--name", "own", "--joints", "4", "--out", path("own.yaml")})
          .exit_code,
      0);
  EXPECT_EQ(config::load_robot(path("own.yaml")).joint_count(), 4);
}

TEST_F(RobotCommands, CheckNamesTheRowThatDoesNotFitThePendant) {
  const std::string joints = folder_.write("J.csv", kShownJoints);
  std::string poses = run_program("truepose", {"fk", "--robot", "kr210_r2700_2", "--joints", joints}).out;
  ASSERT_TRUE(poses.starts_with("x,y,z,a,b,c\n"));
  poses = folder_.write("P.csv", "X,Y,Z,A,B,C" + poses.substr(11));
  const Finished fits =
      run_program("truepose", {"robot", "check", "kr210_r2700_2", "--joints", joints, "--poses", poses});
  EXPECT_EQ(fits.exit_code, 0) << fits.err;
  EXPECT_THAT(fits.out, HasSubstr("largest difference 0.000 mm, 0.0000 deg (limits 0.5 mm, 0.05 deg)"));

  std::string text = text_of(kRobot);
  text.replace(text.find("d: 1220"), 7, "d: 1200");
  const std::string wrong = folder_.write("wrong.yaml", text);
  const Finished misses =
      run_program("truepose", {"robot", "check", wrong, "--joints", joints, "--poses", poses});
  EXPECT_EQ(misses.exit_code, 1);
  EXPECT_THAT(misses.out, HasSubstr("largest difference 20.000 mm"));
  EXPECT_EQ(misses.err, "truepose: " + wrong +
                            ": does not fit the pendant: change row 4: d +20.000 mm (leaves 0.000 mm)\n");

  const Finished other =
      run_program("truepose", {"robot", "check", "kr16_2", "--joints", joints, "--poses", poses});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.err, HasSubstr("no single row explains it. Check signs and zeros of all joints"));
  const std::string fewer = folder_.write("fewer.csv", "X,Y,Z,A,B,C\n1,2,3,4,5,6\n");
  EXPECT_THAT(run_program("truepose", {"robot", "check", wrong, "--joints", joints, "--poses", fewer}).err,
              HasSubstr("J.csv has 3 rows, "));
}

}  // namespace
}  // namespace truepose
