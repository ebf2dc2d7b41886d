#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <pugixml.hpp>
#include <sstream>

#include "config/frame_file.hpp"
#include "config/model_export.hpp"
#include "config/number_text.hpp"
#include "config/table/csv_reader.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose::config {
namespace {

Eigen::Vector3d triple(const pugi::xml_attribute& attribute) {
  std::istringstream in{attribute.value()};
  Eigen::Vector3d v;
  in >> v.x() >> v.y() >> v.z();
  EXPECT_TRUE(in) << attribute.value();
  return v;
}

/// Pose of the flange in base_link as any reader of URDF computes it, in m and rad.
Eigen::Isometry3d urdf_kinematics(const pugi::xml_node& robot, const JointVector& q_chain) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  std::string link = "base_link";
  for (Eigen::Index moving = 0; link != "flange";) {
    pugi::xml_node joint = robot.child("joint");
    while (joint && joint.child("parent").attribute("link").value() != link)
      joint = joint.next_sibling("joint");
    if (!joint) throw std::runtime_error("no joint leaves " + link);
    const Eigen::Vector3d rpy = triple(joint.child("origin").attribute("rpy"));
    X.translate(triple(joint.child("origin").attribute("xyz")));
    X.rotate(rotation_zyx(rpy.z(), rpy.y(), rpy.x()));
    const std::string type = joint.attribute("type").value();
    if (type != "fixed") {
      const Eigen::Vector3d axis = triple(joint.child("axis").attribute("xyz"));
      const double value = q_chain[moving++];
      if (type == "revolute") X.rotate(Eigen::AngleAxisd(value, axis));
      if (type == "prismatic") X.translate(value / 1000 * axis);
    }
    link = joint.child("child").attribute("link").value();
  }
  return X;
}

TEST(Urdf, MovesLikeTheCalibratedArmForEveryKindOfArm) {
  Random random{20261121};
  RobotModel flanged = example::kr210();
  flanged.X_flange = pose_from_kuka({10, -20, 30}, {15, 90, -35});
  RobotModel in_the_gimbal = example::kr210();
  in_the_gimbal.joints[3].beta_rad = std::numbers::pi / 2;
  for (const RobotModel& nominal :
       {example::kr210(), example::seven_axis(), example::kr210_on_a_rail(), flanged, in_the_gimbal}) {
    for (const double errors : {0., 1.}) {
      const RobotModel robot = example::deviating(nominal, random, errors, 2e-3 * errors);
      pugi::xml_document document;
      ASSERT_TRUE(document.load_string(urdf(robot).c_str()));
      for (int k = 0; k < 20; ++k) {
        const JointVector q = example::random_joints(robot, random);
        const Eigen::Isometry3d expected = forward_kinematics(robot, q);
        const Eigen::Isometry3d found = urdf_kinematics(document.child("robot"), q);
        EXPECT_LT((1000 * found.translation() - expected.translation()).norm(), 1e-9) << robot.name;
        EXPECT_LT((found.linear() - expected.linear()).norm(), 1e-12) << robot.name;
      }
    }
  }
}

TEST(Urdf, HasTheJointsOfTheChainWhereTheControllersAreCoupled) {
  Random random{20261123};
  const RobotModel robot = example::lr_mate();
  const std::string text = urdf(robot);
  EXPECT_NE(text.find("m and rad. joint_3 takes the controller's q3 + 1 * q2. -->"), std::string::npos);
  EXPECT_NE(text.find("upper=\"" + format_number(robot.joints[1].max + robot.joints[2].max) + '"'),
            std::string::npos);
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(text.c_str()));
  const JointVector q = example::random_joints(robot, random);
  JointVector q_chain = q;
  q_chain[2] += q[1];
  const Eigen::Isometry3d found = urdf_kinematics(document.child("robot"), q_chain);
  EXPECT_LT((1000 * found.translation() - forward_kinematics(robot, q).translation()).norm(), 1e-9);
}

TEST(Urdf, CarriesLimitsAndSpeedsInMetresAndRadians) {
  const RobotModel robot = example::kr210_on_a_rail();
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(urdf(robot).c_str()));
  const auto limit = [&](const char* joint, const char* name) {
    return document.child("robot")
        .find_child_by_attribute("joint", "name", joint)
        .child("limit")
        .attribute(name)
        .as_double();
  };
  EXPECT_EQ(limit("joint_1", "lower"), -2);
  EXPECT_EQ(limit("joint_1", "velocity"), 1);
  EXPECT_EQ(limit("joint_3", "lower"), robot.joints[2].min);
  EXPECT_EQ(limit("joint_3", "upper"), robot.joints[2].max);
  EXPECT_EQ(limit("joint_3", "velocity"), robot.joints[2].speed);
}

TEST(Urdf, HoldsARobotOfAnyName) {
  RobotModel robot = example::kr210();
  robot.name = "arm \"A\" <left> & co";
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(urdf(robot).c_str()));
  EXPECT_EQ(document.child("robot").attribute("name").value(), robot.name);
}

TEST(Urdf, SaysWhatOfTheArmItCannotHold) {
  RobotModel robot = example::kr210();
  EXPECT_NE(urdf(robot).find("<!-- Kinematics alone. m and rad. -->"), std::string::npos);
  robot.deviation.push_back({.joint = 1});
  EXPECT_NE(urdf(robot).find("rad. Without the deviations of its joints, which URDF cannot hold. -->"),
            std::string::npos);
}

TEST(ParameterCsv, ListsEveryParameterWithItsUnitAndDeviation) {
  const std::vector<IdentifiedParameter> parameters{
      {.name = "base.rx", .value = 0.1, .sigma = 1e-5, .identified = true, .data_share = 1},
      {.name = "smr.a,\"b\".x", .value = 61.5, .sigma = 0.01, .identified = true, .data_share = 1},
      {.name = "link2.a",
       .nominal = 330,
       .value = 330.625,
       .sigma = 0.004,
       .identified = true,
       .data_share = 1},
      {.name = "link3.beta", .nominal = 0.25, .value = 0.25},
      {.name = "joint1.scale", .value = 0.5, .sigma = 0.25, .identified = true, .data_share = 0.75},
      {.name = "joint1.shiftx2", .value = 0.5, .sigma = 0.25, .identified = true, .data_share = 1},
      {.name = "joint1.turnz1", .value = 0.5, .sigma = 0.25, .identified = true, .data_share = 1},
      {.name = "joint3.gravity", .value = 0.5, .sigma = 0.25, .identified = true, .data_share = 1},
      {.name = "joint3.weight8", .value = 0.5, .sigma = 0.25, .identified = true, .data_share = 1},
      {.name = "joint3.sin2", .value = 0.5, .sigma = 0.25, .identified = true, .data_share = 1}};
  RobotModel robot = example::kr210_on_a_rail();
  robot.deviation = {{.joint = 0, .basis = DeviationBasis::Scale},
                     {.joint = 0, .basis = DeviationBasis::ShiftX, .order = 2},
                     {.joint = 0, .basis = DeviationBasis::TurnZ},
                     {.joint = 2, .basis = DeviationBasis::Gravity},
                     {.joint = 2, .basis = DeviationBasis::Weight, .order = 8},
                     {.joint = 2, .basis = DeviationBasis::Sine, .order = 2}};
  EXPECT_EQ(parameter_csv(parameters, robot),
            "name,unit,nominal,value,deviation,sigma,identified,data_share\n"
            "base.rx,rad,,0.1,,1e-05,true,1\n"
            "\"smr.a,\"\"b\"\".x\",mm,,61.5,,0.01,true,1\n"
            "link2.a,mm,330,330.625,0.625,0.004,true,1\n"
            "link3.beta,rad,0.25,0.25,0,,false,0\n"
            "joint1.scale,mm/m,,0.5,,0.25,true,0.75\n"
            "joint1.shiftx2,mm,,0.5,,0.25,true,1\n"
            "joint1.turnz1,rad,,0.5,,0.25,true,1\n"
            "joint3.gravity,rad/kNm,,0.5,,0.25,true,1\n"
            "joint3.weight8,rad/m,,0.5,,0.25,true,1\n"
            "joint3.sin2,rad,,0.5,,0.25,true,1\n");
}

TEST(ParameterCsv, IsReadBackByTheProjectsOwnReaderWithoutLoss) {
  const std::vector<IdentifiedParameter> parameters{
      {.name = "smr.tool, left.x", .value = 1.0 / 3, .sigma = 1e-17, .identified = true}};
  const CsvTable table = CsvTable::parse(parameter_csv(parameters, example::kr210()), "parameters.csv");
  EXPECT_EQ(table.text(0, table.column("name")), parameters[0].name);
  EXPECT_EQ(table.number(0, table.column("value")), parameters[0].value);
  EXPECT_EQ(table.number(0, table.column("sigma")), parameters[0].sigma);
}

TEST(FrameReadingsCsv, MakesUpNoCoordinatesOfAPointThatHasNone) {
  const FrameReadings data{.points = {{"a", Eigen::Vector3d(1, 2, 3)}, {"b", std::nullopt}},
                           .readings = {{.point = 1, .p_WS_mm = Eigen::Vector3d(4, 5, 6)}}};
  std::ostringstream out;
  EXPECT_THROW(write_frame_readings(out, data, example::kr210()), std::bad_optional_access);
}

}  // namespace
}  // namespace truepose::config
