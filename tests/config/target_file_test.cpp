#include "config/target_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "config/frame_file.hpp"
#include "config/table/table_reading.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::ElementsAre, testing::HasSubstr;

struct ReadTargets {
  TargetForm form;
  std::vector<TargetRow> rows;
};

ReadTargets targets(const std::string& text, const TargetRules& rules) {
  std::istringstream in{text};
  TargetReader reader{in, "targets.csv", rules};
  ReadTargets read{reader.form(), {}};
  while (auto row = reader.next()) read.rows.push_back(*std::move(row));
  return read;
}

std::string error(const std::string& text, const TargetRules& rules) {
  return error_of([&] { targets(text, rules); }, "targets.csv");
}

TEST(TargetFile, TellsItsFormByItsColumns) {
  const ReadTargets joints = targets("sigma_mm,q2,q1\n0.1,20,10\n0.1,40,30\n", {});
  EXPECT_EQ(joints.form, TargetForm::Joints);
  ASSERT_EQ(joints.rows.size(), 2U);
  EXPECT_THAT(joints.rows[0].numbers, ElementsAre(10, 20));
  EXPECT_THAT(joints.rows[1].numbers, ElementsAre(30, 40));
  const ReadTargets poses = targets("a,b,c,x,y,z\n4,5,6,1,2,3\n", {});
  EXPECT_EQ(poses.form, TargetForm::Poses);
  EXPECT_THAT(poses.rows.at(0).numbers, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(TargetFile, KnowsHowManyJointsAnArmHas) {
  const RobotModel arm = published_arm();
  EXPECT_EQ(error("q1,q2\n10,20\n", {.arm = &arm}), "targets.csv: missing column 'q3'");
  EXPECT_EQ(error("q1,q2,q3,q4,q5,q6,q7\n1,2,3,4,5,6,7\n", {.arm = &arm}),
            "targets.csv: unknown column 'q7', did you mean 'q1'?");
  EXPECT_EQ(error("x,y,z\n1,2,3\n", {.arm = &arm, .of_joints = true}),
            "targets.csv: unknown column 'x'. Known here: q1, q2, q3, q4, q5, q6, residual_mm, "
            "residual_deg, sigma_mm");
}

TEST(TargetFile, GivesStatusAndTurnAndPositionsAloneWhereTheyAreTaken) {
  const TargetRules rules{.of_joints = false, .whole_poses_alone = false};
  const ReadTargets poses = targets("x,y,z,a,b,c,s,t\n1,2,3,4,5,6,2,43\n", rules);
  EXPECT_EQ(poses.form, TargetForm::Poses);
  EXPECT_EQ(poses.rows.at(0).status, 2);
  EXPECT_EQ(poses.rows.at(0).turn, 43);
  const ReadTargets positions = targets("x,y,z\n1,2,3\n", rules);
  EXPECT_EQ(positions.form, TargetForm::Positions);
  EXPECT_THAT(positions.rows.at(0).numbers, ElementsAre(1, 2, 3));
  EXPECT_FALSE(positions.rows.at(0).status);
}

// Passed over, they would have the arm come on another branch than the file says.
TEST(TargetFile, RefusesStatusAndTurnInASentenceWhereTheBranchIsNotChosenByThem) {
  for (const char* text : {"x,y,z,a,b,c,s\n1,2,3,4,5,6,2\n", "x,y,z,a,b,c,t\n1,2,3,4,5,6,2\n"})
    EXPECT_EQ(
        error(text, {}),
        "targets.csv: columns s and t: here the branch is the one nearest to the target before; leave them out, "
        "or give joints");
  EXPECT_EQ(error("x,y,z\n1,2,3\n", {}), "targets.csv: missing column 'a'");
}

TEST(TargetFile, WithoutARowIsRefused) { EXPECT_EQ(error("q1,q2\n", {}), "targets.csv: no rows of data"); }

TEST(PointFile, GivesEachPointWhatItsColumnsTell) {
  const TempFolder folder;
  const auto points =
      load_points(folder.write("p.csv", "pz,py,px,point,x,y,z\n3,2,1,a,4,5,6\n9,8,7,b,1,1,1\n"));
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].name, "a");
  EXPECT_EQ(points[0].at_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(points[0].known_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(points[1].name, "b");
  const auto named = load_points(folder.write("named.csv", "point\norigin\n"));
  EXPECT_EQ(named.at(0).name, "origin");
  EXPECT_FALSE(named.at(0).at_mm || named.at(0).known_mm);
}

TEST(PointFile, RefusesCoordinatesThatAreNotThree) {
  const TempFolder folder;
  const auto error = [&](const std::string& text) {
    const auto file = folder.write("p.csv", text);
    return error_of([&] { load_points(file); }, file);
  };
  EXPECT_EQ(error("x,y,z\n1,2,3\n"), "p.csv: missing column 'point'");
  EXPECT_EQ(error("point,px,py\na,1,2\n"), "p.csv: missing column 'pz'");
  EXPECT_EQ(error("point,y,z\na,1,2\n"), "p.csv: missing column 'x'");
  EXPECT_THAT(error("point,x,y,z,smr\na,1,2,3,1\n"), HasSubstr("unknown column 'smr'"));
}

TEST(TargetFile, TakesOrientationsWhoseNamesSayWhichTheyAre) {
  const TableReading reading;
  const auto pose = [&](const std::string& text) {
    std::istringstream in{text};
    TargetReader reader{
        in, "targets.csv", {.of_joints = false, .whole_poses_alone = false, .reading = &reading}};
    return reader.next()->numbers;
  };
  const std::vector<double> abc{1, 2, 3, 90, 0, 0};
  const auto near = testing::Pointwise(testing::DoubleNear(1e-9), abc);
  EXPECT_THAT(pose("X [mm];Y [mm];Z [mm];qw;qx;qy;qz\n1;2;3;0,70710678118654752;0;0;0,70710678118654752\n"),
              near);
  EXPECT_THAT(pose("x,y,z,roll,pitch,yaw\n1,2,3,0,0,90\n"), near);
  EXPECT_THAT(pose("X\tY\tZ\tW\tP\tR\n1\t2\t3\t0\t0\t90\n"), near);
  EXPECT_THAT(pose("pose\n{E6POS: X 1.0,Y 2.0,Z 3.0,A 90.0,B 0.0,C 0.0,S 2,T 10,E1 0.0}\n"), near);
  const auto refused = [&](const std::string& text) { return error_of([&] { pose(text); }, "targets.csv"); };
  EXPECT_THAT(refused("x,y,z,rx,ry,rz\n1,2,3,0,0,1.57\n"),
              testing::HasSubstr("may be a rotation vector (rad, Universal Robots) or angles"));
  EXPECT_THAT(refused("x,y,z,roll,pitch,yaw\n1,2,3,0,0,1.57\n"),
              testing::HasSubstr("roll, pitch, yaw: no angle is beyond 1.57: they may be deg or rad"));
  EXPECT_THAT(refused("x,y,z,qw,qx,qy,qz\n1,2,3,1,1,0,0\n"),
              testing::HasSubstr("the quaternion has the length 1.414, expected 1"));
}

}  // namespace
}  // namespace truepose::config
