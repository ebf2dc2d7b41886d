#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include "config/import/dh_table.hpp"
#include "config/import/machine_data.hpp"
#include "config/import/opw_file.hpp"
#include "config/import/urdf_file.hpp"
#include "config/import/xacro_expression.hpp"
#include "config/model_export.hpp"
#include "config/robot_file.hpp"
#include "config/robot_library.hpp"
#include "config/table/csv_reader.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "tests/config/error_of.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::ElementsAre, testing::HasSubstr, testing::StartsWith;

/// The largest distance of the flange (mm, with 1 rad as 1000 mm) between two arms at random joints.
double largest_difference(const RobotModel& a, const RobotModel& b) {
  Random random{5};
  double largest = 0;
  for (int i = 0; i < 50; ++i) {
    JointVector q(a.joint_count());
    for (double& each : q) each = random.uniform(-3, 3);
    const Eigen::Isometry3d X = forward_kinematics(a, q), Y = forward_kinematics(b, q);
    largest = std::max(
        {largest, (X.translation() - Y.translation()).norm(), 1000 * angle_between(X.linear(), Y.linear())});
  }
  return largest;
}

// ---- KUKA machine data

/// What an archive of a KR 210 R2700-2 says, in the words of its file.
std::string machine_data() {
  std::string text = R"(DEFDAT $MACHINE PUBLIC
INT $NUM_AX=6 ;ACHSEN DES ROBOTERSYSTEMS
$TRAFONAME[]="#KR210R2700_2 C4 FLR" ;MAXIMAL 32 ZEICHEN
DECL MAIN_AXIS $MAIN_AXIS=#NR
DECL WRIST_AXIS $WRIST_AXIS=#ZEH ;HANDACHSENKENNUNG
FRAME $TIRORO={X 0.0,Y 0.0,Z 645.000,A 0.0,B 0.0,C 0.0} ;FRAME
FRAME $TFLWP={x 0.0,y 0.0,z 215.000,a 0.0,b 0.0,c 0.0}
FRAME $TX3P3={X 1220.00,Y 0.0,Z 115.000,A 0.0,B 90.0000,C 0.0}
REAL $LENGTH_A=330.000 ;GRUNDACHSLAENGE A
REAL $LENGTH_B=1150.00
DECL DHART $DH_4={DHART_A 0.0,DHART_D 0.0,DHART_ALPHA 90.0000}
DECL DHART $DH_5={DHART_A 0.0,DHART_D 0.0,DHART_ALPHA -90.0000}
)";
  const char* const kAxes[6][5] = {{"-185.000", "185.000", "-1", "{N -1798,D 7}", "5000.00"},
                                   {"-140.000", "-5.00000", "1", "{N -4576,D 17}", "4999.99805"},
                                   {"-120.000", "168.000", "1", "{N 754,D 3}", "4691.55566"},
                                   {"-350.000", "350.000", "-1", "{N -10387,D 55}", "5634.16064"},
                                   {"-125.000", "125.000", "-1", "{N -91834,D 483}", "5450.46533"},
                                   {"-350.000", "350.000", "-1", "{N 6485103,D 49400}", "4813.50439"}};
  for (int axis = 1; axis <= 6; ++axis) {
    const auto& row = kAxes[axis - 1];
    const std::string at = "[" + std::to_string(axis) + "]=";
    text += "$SOFTN_END" + at + row[0] + "\r\n$SOFTP_END" + at + row[1] + "\n$AXIS_DIR" + at + row[2] +
            "\n$RAT_MOT_AX" + at + row[3] + "\n$VEL_AXIS_MA" + at + row[4] + "\n";
  }
  return text + "ENDDAT\n";
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_shipped_kr210(const RobotModel& robot) {
  const RobotModel shipped = load_robot("kr210_r2700_2");
  EXPECT_EQ(robot.name, "KUKA KR210R2700_2 C4 FLR");
  ASSERT_EQ(robot.joint_count(), 6);
  for (std::size_t i = 0; i < 6; ++i) {
    const Joint &a = robot.joints[i], &b = shipped.joints[i];
    EXPECT_EQ(a.a_mm, b.a_mm) << i;
    EXPECT_EQ(a.alpha_rad, b.alpha_rad) << i;
    EXPECT_EQ(a.d_mm, b.d_mm) << i;
    EXPECT_EQ(a.theta_rad, b.theta_rad) << i;
    EXPECT_EQ(a.sign, b.sign) << i;
    EXPECT_EQ(a.min, b.min) << i;
    EXPECT_EQ(a.max, b.max) << i;
    EXPECT_NEAR(a.speed, b.speed, 0.1 * kRadPerDeg) << i;
  }
  EXPECT_TRUE(robot.X_flange.isApprox(shipped.X_flange));
}

TEST(MachineData, OfTheShippedKr210AreItsRobotFile) {
  expect_shipped_kr210(robot_of_machine_data(machine_data(), "$machine.dat"));
}

TEST(MachineData, OfTheQuickstartsArchiveAreTheShippedKr210) {
  expect_shipped_kr210(load_machine_data(std::string{TRUEPOSE_SOURCE_DIR} + "/config/quickstart/archive"));
}

TEST(MachineData, AreFoundInAnArchiveThatHoldsThem) {
  const TempFolder folder;
  std::filesystem::create_directories(folder.path() / "KRC/R1/Mada");
  folder.write("KRC/R1/Mada/$machine.dat", machine_data());
  EXPECT_EQ(load_machine_data(folder.path()).joint_count(), 6);
  EXPECT_EQ(load_machine_data(folder.path() / "KRC/R1/Mada/$machine.dat").joint_count(), 6);
}

TEST(MachineData, OfAWholeArchiveAreThoseOfTheArmAndNotOfItsController) {
  const RobotModel arm = load_machine_data(TRUEPOSE_SOURCE_DIR "/tests/proto/krl_corpus/kss87");
  EXPECT_LT(largest_difference(arm, load_robot("kr210_r2700_2")), 1e-9);
}

TEST(MachineData, OfAnotherKindOfArmAreRefusedByTheNameOfTheNumber) {
  const auto error = [](const std::string& from, const std::string& to) {
    return error_of([&] { robot_of_machine_data(with(machine_data(), from, to), "$machine.dat"); }, "");
  };
  EXPECT_THAT(error("#ZEH", "#WIH"),
              StartsWith("$machine.dat: $WRIST_AXIS: is #WIH, and only #ZEH is known"));
  EXPECT_THAT(error("$AXIS_DIR[3]=1", "$AXIS_DIR[3]=-1"), StartsWith("$machine.dat: $AXIS_DIR[3]: is -1"));
  EXPECT_THAT(error("Z 645.000,A 0.0", "Z 645.000,A 5.0"), StartsWith("$machine.dat: $TIRORO: A is 5"));
  EXPECT_THAT(error("$LENGTH_A=330.000", "$LENGTH_C=330.000"),
              StartsWith("$machine.dat: $LENGTH_A: is missing"));
  EXPECT_THAT(error("$LENGTH_B=1150.00", "$LENGTH_B=long"),
              StartsWith("$machine.dat: $LENGTH_B: not a number: 'LONG'"));
}

// ---- xacro

class Xacro : public testing::Test {
 protected:
  ImportedArm load(const std::string& text, const UrdfOptions& options = {}) {
    return load_urdf(folder_.write("arm.xacro", text), options);
  }
  std::string error(const std::string& text, const UrdfOptions& options = {}) {
    const auto file = folder_.write("arm.xacro", text);
    return error_of([&] { load_urdf(file, options); }, file);
  }
  TempFolder folder_;
};

constexpr char kMacro[] = R"xml(<robot xmlns:xacro="http://wiki.ros.org/xacro">
  <xacro:property name="height" value="0.4"/>
  <xacro:property name="twice" value="${2 * height}"/>
  <xacro:macro name="turning" params="prefix number parent z:=0 *origin axis:='0 0 1'">
    <link name="${prefix}link_${number}">
      <visual><geometry><mesh filename="${no_such_thing}"/></geometry></visual>
      <inertial><mass value="${number * 3}"/><origin xyz="0.1 0 0"/></inertial>
    </link>
    <joint name="${prefix}joint_${number}" type="revolute">
      <xacro:insert_block name="origin"/>
      <parent link="${prefix}${parent}"/><child link="${prefix}link_${number}"/>
      <axis xyz="${axis}"/>
      <limit lower="${radians(-100)}" upper="${pi / 2}" velocity="${radians(120 if number == 1 else 60)}" effort="0"/>
    </joint>
  </xacro:macro>
</robot>
)xml";

constexpr char kXacroArm[] = R"xml(<?xml version="1.0"?>
<robot name="two" xmlns:xacro="http://wiki.ros.org/xacro">
  <xacro:arg name="prefix" default="left_"/>
  <xacro:arg name="long" default="false"/>
  <xacro:include filename="$(find arm_support)/urdf/macro.xacro"/>
  <link name="$(arg prefix)base_link"/>
  <xacro:turning prefix="$(arg prefix)" number="1" parent="base_link">
    <origin xyz="0 0 ${twice}" rpy="0 0 0"/>
  </xacro:turning>
  <xacro:turning prefix="$(arg prefix)" number="2" parent="link_1" axis="0 1 0">
    <origin xyz="${0.5 - 0.2} 0 0" rpy="0 0 0"/>
  </xacro:turning>
  <xacro:if value="$(arg long)"><link name="end"/><joint name="fix" type="fixed">
    <parent link="$(arg prefix)link_2"/><child link="end"/><origin xyz="1 0 0"/></joint></xacro:if>
  <xacro:unless value="$(arg long)"><link name="end"/><joint name="fix" type="fixed">
    <parent link="$(arg prefix)link_2"/><child link="end"/><origin xyz="0.5 0 0" rpy="0 ${radians(90)} 0"/>
  </joint></xacro:unless>
  <gazebo><plugin name="${also_unknown}"/></gazebo>
</robot>
)xml";

TEST_F(Xacro, ExpandsPropertiesArgumentsMacrosBlocksConditionsAndIncludes) {
  std::filesystem::create_directories(folder_.path() / "arm_support/urdf");
  folder_.write("arm_support/urdf/macro.xacro", kMacro);
  const ImportedArm arm = load(kXacroArm, {.takes_masses = true});
  EXPECT_EQ(arm.robot.name, "two");
  EXPECT_THAT(arm.notes, ElementsAre("base: link left_base_link; flange: link end"));
  ASSERT_EQ(arm.robot.joint_count(), 2);
  EXPECT_EQ(arm.robot.joints[0].d_mm, 800);
  EXPECT_EQ(arm.robot.joints[1].a_mm, 300);
  EXPECT_DOUBLE_EQ(arm.robot.joints[0].speed, 120 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(arm.robot.joints[1].speed, 60 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(arm.robot.joints[1].min, -100 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(arm.robot.joints[1].max, 90 * kRadPerDeg);
  ASSERT_EQ(arm.robot.masses.size(), 2u);
  EXPECT_EQ(arm.robot.masses[1].mass_kg, 6);
  const Eigen::Isometry3d X = forward_kinematics(arm.robot, JointVector::Zero(2));
  EXPECT_NEAR((X.translation() - Eigen::Vector3d{800, 0, 800}).norm(), 0, 1e-9);
  EXPECT_NEAR((X.linear().col(2) - Eigen::Vector3d{1, 0, 0}).norm(), 0, 1e-12);
  const ImportedArm other = load(kXacroArm, {.arguments = {{"long", "true"}, {"prefix", ""}}});
  EXPECT_NEAR(forward_kinematics(other.robot, JointVector::Zero(2)).translation().x(), 1300, 1e-9);
}

TEST_F(Xacro, ThatIsNotUnderstoodIsRefusedWithFileAndLine) {
  const auto in_robot = [this](const std::string& text) {
    return error("<robot name='a' xmlns:xacro='http://wiki.ros.org/xacro'>\n\n" + text + "</robot>");
  };
  EXPECT_THAT(in_robot("<link name='${wide}'/>"),
              StartsWith("arm.xacro:3: <link>: ${wide}: 'wide' is not defined"));
  EXPECT_THAT(in_robot("<xacro:arm/>"),
              StartsWith("arm.xacro:3: <xacro:arm>: no macro of this name is defined"));
  EXPECT_THAT(in_robot("<xacro:include filename='colours.xacro'/><xacro:arm/>"), HasSubstr("(not found: "));
  EXPECT_THAT(in_robot("<link name='$(eval 1)'/>"),
              StartsWith("arm.xacro:3: <link>: $(eval 1) is not understood"));
  EXPECT_THAT(in_robot("<link name='$(arg x)'/>"), HasSubstr("Give --arg x=VALUE."));
  EXPECT_THAT(in_robot("<xacro:if value='maybe'/>"), HasSubstr("expected true or false, found 'maybe'"));
  EXPECT_THAT(in_robot("<xacro:property name='a' value='${a}'/><link name='${a}'/>"),
              HasSubstr("names itself"));
  EXPECT_THAT(in_robot("<xacro:macro name='m' params='x'/><xacro:m/>"),
              HasSubstr("the parameter 'x' is missing"));
  EXPECT_THAT(in_robot("<xacro:macro name='m' params=''/><xacro:m y='1'/>"),
              HasSubstr("has no parameter 'y'"));
  EXPECT_THAT(in_robot("<include filename='x'/>"), HasSubstr("Write it with the prefix xacro:"));
  EXPECT_THAT(error("<robot><link></robot>"), StartsWith("arm.xacro:1: no XML: "));
  EXPECT_THAT(error("<sdf/>"), HasSubstr("expected <robot>"));
  EXPECT_THAT(error("<robot name='a'/>"), HasSubstr("no joint in it"));
}

TEST_F(Xacro, WithSeveralEndsOrOtherJointsAsksForTheLinks) {
  const std::string ends = R"xml(<robot name="fork"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="j1" type="revolute"><parent link="a"/><child link="b"/><limit lower="-1" upper="1" velocity="1"/></joint>
    <joint name="j2" type="TYPE"><parent link="a"/><child link="c"/><axis xyz="1 0 0"/>MIMIC</joint></robot>)xml";
  EXPECT_THAT(error(with(with(ends, "TYPE", "prismatic"), "MIMIC", "")),
              HasSubstr("which link is meant? Give --tip, one of: b, c"));
  EXPECT_EQ(load(with(with(ends, "TYPE", "prismatic"), "MIMIC", ""), {.tip = "b"}).robot.joint_count(), 1);
  EXPECT_THAT(load(with(with(ends, "TYPE", "prismatic"), "MIMIC", ""), {.tip = "c"}).notes.back(),
              HasSubstr("joint 'j2': no limits in the source"));
  EXPECT_THAT(error(with(with(ends, "TYPE", "floating"), "MIMIC", ""), {.tip = "c"}),
              HasSubstr("a joint of type 'floating' cannot be part of the arm"));
  EXPECT_THAT(error(with(with(ends, "TYPE", "prismatic"), "MIMIC", "<mimic joint='j1'/>"), {.tip = "c"}),
              HasSubstr("follows another joint (mimic)"));
  EXPECT_THAT(error(with(with(ends, "TYPE", "prismatic"), "MIMIC", ""), {.tip = "d"}),
              HasSubstr("no link 'd' in it"));
  EXPECT_THAT(error(with(ends, "<link name=\"b\"/>", "")),
              HasSubstr("joint 'j1': its link 'b' is not in the file. Add it."));
  EXPECT_THAT(error(with(ends, "lower=\"-1\"", "lower=\"2\""), {.tip = "b"}),
              HasSubstr("joint 'j1': limit: lower is above upper. Correct them."));
}

TEST(XacroExpression, HasTheArithmeticOfPublicDescriptions) {
  const auto value = [](const std::string& text) {
    const auto result = evaluate_xacro(text, [](const std::string& name) -> std::optional<XacroValue> {
      if (name == "mode") return "mock";
      if (name == "width") return 0.5;
      return std::nullopt;
    });
    return result ? xacro_text(*result) : "! " + result.error();
  };
  EXPECT_EQ(value("1 + 2 * 3 - 4 / 8"), "6.5");
  EXPECT_EQ(value("-(1 + 2)*-width"), "1.5");
  EXPECT_EQ(value("2**3 % 5"), "3");
  EXPECT_EQ(value("-radians(180) + pi"), "0");
  EXPECT_EQ(value("mode == 'mock' and width < 1"), "1");
  EXPECT_EQ(value("not (mode != 'mock') or False"), "1");
  EXPECT_EQ(value("'a' + 'b' if width > 1 else max(1, 2, sqrt(9))"), "3");
  EXPECT_EQ(value("atan2(0, 1)"), "0");
  EXPECT_EQ(value("1e-3"), "0.001");
  EXPECT_EQ(value("height"), "! 'height' is not defined");
  EXPECT_EQ(value("1 / 0"), "! division by 0");
  EXPECT_EQ(value("1 +"), "! ends too early");
  EXPECT_EQ(value("(1"), "! a ) is missing");
  EXPECT_EQ(value("mode * 2"), "! 'mock' is not a number");
  EXPECT_EQ(value("exit(1)"), "! the function exit() is not known");
  EXPECT_THAT(value("xacro.load_yaml('x')"),
              StartsWith("! 'xacro': members and elements are not understood"));
  EXPECT_EQ(value(std::string(5000, '(')), "! is nested too deeply");
}

TEST_F(Xacro, SaysWhereTheBaseStandsWhereNoRowReachesTheFirstAxis) {
  const ImportedArm arm = load(R"xml(<robot name="aside"><link name="a"/><link name="b"/>
    <joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.1 0.2 0.3"/><axis xyz="0 0 1"/>
      <limit lower="-1" upper="1" velocity="1"/></joint></robot>)xml");
  EXPECT_THAT(arm.notes.back(), HasSubstr("it stands at x 100, y 200, z 0 mm of link a"));
  EXPECT_EQ(arm.robot.joints[0].d_mm, 300);
  EXPECT_EQ(arm.robot.joints[0].a_mm, 0);
}

TEST_F(Xacro, ReadsAnExportedUrdfBackToTheSameForwardKinematics) {
  Random random{8};
  for (const RobotModel& nominal :
       {example::kr210(), example::seven_axis(), example::kr210_on_a_rail(), example::ur10()}) {
    const RobotModel robot = example::deviating(nominal, random, 1, 2e-3);
    EXPECT_LT(largest_difference(load(urdf(robot)).robot, robot), 1e-9) << robot.name;
  }
}

// ---- DH tables and OPW

class DhTable : public testing::Test {
 protected:
  RobotModel load(const std::string& text, DhConvention convention,
                  const std::optional<DhUnits>& units = {}) {
    return load_dh_table(folder_.write("table.csv", text), convention, units).robot;
  }
  std::string error(const std::string& text, DhConvention convention = DhConvention::Standard) {
    const auto file = folder_.write("table.csv", text);
    return error_of([&] { load_dh_table(file, convention, {}); }, file);
  }
  TempFolder folder_;
};

TEST_F(DhTable, OfAUr10InMetresAndRadiansIsTheShippedOne) {
  const std::string table =
      "a,alpha,d,theta\n0,1.5707963267948966,0.1273,0\n-0.612,0,0,0\n-0.5723,0,0,0\n0,1.5707963267948966,0.163941,0\n"
      "0,-1.5707963267948966,0.1157,0\n0,0,0.0922,0\n";
  EXPECT_LT(largest_difference(load(table, DhConvention::Standard, dh_units("m,rad")), load_robot("ur10")),
            1e-9);
}

TEST_F(DhTable, SaysItsUnitsInTheColumnsNames) {
  const RobotModel robot = load(
      "Joint,r (cm),alpha [deg],d_m,offset (deg),sign,min (deg),max (deg),velocity (deg/s)\n"
      "1,10,90,0.2,30,-1,-90,90,100\n",
      DhConvention::Modified);
  const Joint& joint = robot.joints[0];
  EXPECT_EQ(joint.a_mm, 100);
  EXPECT_EQ(joint.d_mm, 200);
  EXPECT_DOUBLE_EQ(joint.alpha_rad * kDegPerRad, 90);
  EXPECT_DOUBLE_EQ(joint.theta_rad * kDegPerRad, 30);
  EXPECT_EQ(joint.sign, -1);
  EXPECT_DOUBLE_EQ(joint.max * kDegPerRad, 90);
}

TEST_F(DhTable, IsReadAsAMeasurementFileIsWithOtherSeparatorsAndDecimalCommas) {
  const std::string header = "a (mm),alpha (deg),d (mm),theta (deg),min (deg),max (deg)\n";
  const RobotModel plain =
      load(header + "330.25,-90,0.5,0,-140,-5\n115,90,1220.125,30.5,-90,90\n", DhConvention::Modified);
  const auto expect_same = [&](std::string text, char separator) {
    std::ranges::replace(text, ',', separator);
    std::ranges::replace(text, '.', ',');
    EXPECT_LT(largest_difference(load(text, DhConvention::Modified), plain), 1e-9) << text;
  };
  for (const char separator : {';', '\t'})
    expect_same(
        "# from the data sheet\n" + header + "330.25,-90,0.5,0,-140,-5\n115,90,1220.125,30.5,-90,90\n",
        separator);
  expect_same(
      "a,alpha,d,theta,min (deg),max (deg)\n"
      "330.25 mm,-90 deg,0.5 mm,0 deg,-140,-5\n115 mm,90 deg,1220.125 mm,30.5 deg,-90,90\n",
      ';');
  EXPECT_THAT(error("a (mm);alpha (deg);d (mm);theta (deg)\n1,5;90;0;0\n1;90;0\n"),
              HasSubstr("table.csv: row 2 (line 3)"));
}

TEST_F(DhTable, IsRefusedWhereUnitsOrColumnsAreInDoubt) {
  EXPECT_THAT(error("a,alpha,d,theta\n1,2,3,4\n"), HasSubstr("column 'a': no unit is said"));
  EXPECT_THAT(error("a (mm),alpha (deg),d (mm)\n1,2,3\n"), HasSubstr("missing column 'theta'"));
  EXPECT_THAT(error("a (deg),alpha (deg),d (mm),theta (deg)\n1,2,3,4\n"),
              HasSubstr("this unit is not known here"));
  EXPECT_THAT(error("a (mm),alpha (deg),d (mm),theta (deg),mass\n1,2,3,4,5\n"),
              HasSubstr("unknown column 'mass'"));
  EXPECT_THAT(error("a (mm),r (mm),alpha (deg),d (mm),theta (deg)\n1,2,3,4,5\n"),
              HasSubstr("is there twice"));
  EXPECT_THAT(error("a (mm),alpha (deg),d (mm),theta (deg),sign\n1,2,3,4,0\n"),
              HasSubstr("expected 1 or -1"));
  EXPECT_THAT(
      error("Link,a (mm),alpha (deg),d (mm),theta (deg)\n1,0,90,127.3,q1\n"),
      HasSubstr("row 1 (line 2): theta (deg): 'q1' names the joint's angle. Write its offset, 0 for none"));
  EXPECT_FALSE(dh_units("mm"));
  EXPECT_FALSE(dh_units("deg,mm"));
}

TEST_F(DhTable, ThatIsExportedReadsBackToTheSameForwardKinematics) {
  Random random{3};
  for (const RobotModel& nominal : {example::kr210(), example::seven_axis(), example::kr210_on_a_rail()}) {
    RobotModel robot = example::deviating(nominal, random, 1, 2e-3);
    robot.X_flange = pose_from_kuka({10, -20, 30}, {15, 80, -35});
    EXPECT_LT(
        largest_difference(load(dh_table_text(robot, DhConvention::Modified), DhConvention::Modified), robot),
        1e-9);
    EXPECT_LT(largest_difference(load(robodk_table_text(robot), DhConvention::Modified), robot), 1e-9);
  }
  for (const char* name : {"ur10", "kr210_r2700_2", "epson_ls6_602s"}) {
    const RobotModel robot = load_robot(name);
    EXPECT_LT(
        largest_difference(load(dh_table_text(robot, DhConvention::Standard), DhConvention::Standard), robot),
        1e-9)
        << name;
  }
  EXPECT_THAT(error_of(
                  [&] {
                    dh_table_text(example::deviating(example::kr210(), random, 1, 2e-3),
                                  DhConvention::Standard);
                  },
                  ""),
              HasSubstr("Export a modified one."));
}

TEST(OpwParameters, OfAKr6AreThatArm) {
  const TempFolder folder;
  const auto file = folder.write(
      "opw.yaml",
      R"(opw_kinematics_geometric_parameters: {a1: 0.025, a2: -0.035, b: 0, c1: 0.4, c2: 0.455, c3: 0.42, c4: 0.08}
opw_kinematics_joint_offsets: [0, deg(-90), 0, 0, 0, 0]
opw_kinematics_joint_sign_corrections: [-1, 1, 1, -1, 1, -1]
)");
  const RobotModel robot = load_opw(file).robot;
  EXPECT_LT(largest_difference(robot, load_robot("kr6_r900_sixx")), 1e-8);
}

// ---- Corrections for a controller

TEST(KukaCorrections, NameTheControllersNumberOrSayThatThereIsNone) {
  const RobotModel robot = load_robot("kr210_r2700_2");
  const std::vector<IdentifiedParameter> parameters{
      {.name = "base.x", .value = 5},
      {.name = "link1.theta", .value = 0.01, .identified = true},
      {.name = "link2.a", .nominal = 330, .value = 330.5, .identified = true},
      {.name = "link3.alpha", .value = -0.002, .identified = true},
      {.name = "link4.d", .nominal = 1220, .value = 1220},
      {.name = "link6.d", .nominal = 215, .value = 214.75, .identified = true}};
  const CsvTable table = CsvTable::parse(kuka_corrections_csv(parameters, robot), "kuka.csv");
  ASSERT_EQ(table.row_count(), 4u);
  const auto text = [&](std::size_t row, const char* column) {
    return std::string{table.text(row, table.column(column))};
  };
  const auto number = [&](std::size_t row, const char* column) {
    return table.number(row, table.column(column));
  };
  EXPECT_EQ(text(0, "where"), "zero of axis 1 (mastering)");
  EXPECT_DOUBLE_EQ(number(0, "change"), -0.01 * kDegPerRad) << "axis 1 counts against its row";
  EXPECT_EQ(text(1, "where"), "$machine.dat $LENGTH_A (by KUKA alone on most controllers)");
  EXPECT_DOUBLE_EQ(number(1, "change"), 0.5);
  EXPECT_EQ(text(2, "where"), "no place in the controller: needs corrected positions");
  EXPECT_EQ(text(3, "where"), "$machine.dat $TFLWP.Z (by KUKA alone on most controllers)");
  EXPECT_THAT(kuka_corrections_csv(parameters, load_robot("m20ia")), testing::Not(HasSubstr("$machine.dat")));
}

// ---- The library

TEST(RobotLibrary, IsFoundByNameFromWhereverTheProgramStands) {
  EXPECT_GE(shipped_robot_files().size(), 25u);
  EXPECT_EQ(robot_file_of("kr16_2").filename(), "kr16_2.yaml");
  EXPECT_EQ(robot_file_of("other/arm.yaml"), "other/arm.yaml");
  EXPECT_THAT(
      error_of([] { robot_file_of("KR 210"); }, ""),
      HasSubstr(
          "did you mean 'kr210_r2700_2' or 'kr210_r2700_extra' or 'kr210_r2700_prime'? See truepose robot list."));
  EXPECT_THAT(error_of([] { robot_file_of("kr16_3"); }, ""),
              StartsWith("kr16_3: no such file, and no shipped robot of this name, did you mean 'kr16_2'?"));
}

}  // namespace
}  // namespace truepose::config
