// A turntable and a tilt-and-turn positioner from their readings to the arm's joints: `truepose calibrate`,
// `truepose positioner`, `truepose compensate --positioner`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/tools/known_arm_command.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

constexpr const char* kTurntable =
    "name: KP1\njoints:\n  - {a: 0, alpha: 0, d: 450, theta: 0, beta: 0, sign: 1, min: -185, max: 185, speed: 60}\n";
constexpr const char* kTiltAndTurn =
    "name: DKP\njoints:\n  - {a: 0, alpha: 90, d: 0, theta: 0, beta: 0, sign: 1, min: -90, max: 90, speed: 60}\n"
    "  - {a: 120, alpha: -90, d: 250, theta: 0, beta: 0, sign: 1, min: -185, max: 185, speed: 60}\n";
constexpr const char* kRoot = "1900,350,-150,25,0,0";

class PositionerCommand : public KnownArmCommand {
 protected:
  PositionerCommand() : KnownArmCommand{23} {}

  std::string cells(const Eigen::VectorXd& numbers, double factor = 1) const {
    std::ostringstream text;
    text.precision(17);
    for (const double number : numbers) text << factor * number << ',';
    return text.str();
  }
  JointVector turned() {
    JointVector e(truth_.joint_count());
    for (Eigen::Index i = 0; i < e.size(); ++i) {
      const Joint& joint = truth_.joints[static_cast<std::size_t>(i)];
      e[i] = random_.uniform(joint.min, joint.max);
    }
    return e;
  }
  /// The table in the robot's base.
  Eigen::Matrix4d table_at(const JointVector& e) const { return X_BR_ * plain::flange(truth_, e); }
  std::string row(const JointVector& e, const Eigen::Vector3d& p_F_mm) {
    const Eigen::Vector3d p_W = model_.cell.base.isometry() * plain::moved(table_at(e), p_F_mm) + noise();
    std::string text = cells(e, kDegPerRad) + cells(p_W);
    text.back() = '\n';
    return text;
  }

  /// Four reflectors on the table at 24 angles, identified by `truepose calibrate`.
  void calibrate_table(const char* robot) {
    table_file_ = folder_.write("table.yaml", robot);
    truth_ = config::load_robot(table_file_);
    if (truth_.joint_count() == 2) truth_.joints[1].a_mm += 0.4;
    std::string text = truth_.joint_count() == 1 ? "smr,q1,x,y,z\n" : "smr,q1,q2,x,y,z\n";
    for (int i = 0; i < 24; ++i) {
      const JointVector e = turned();
      int smr = 0;
      for (const Eigen::Vector3d& p : {Eigen::Vector3d(400, 50, 30), Eigen::Vector3d(-300, 250, 200),
                                       Eigen::Vector3d(-100, -450, 90), Eigen::Vector3d(150, -200, 350)})
        text += std::to_string(++smr) + ',' + row(e, p);
    }
    const Finished finished = run_program(
        "truepose", {"calibrate", "--robot", table_file_, "--data", folder_.write("table.csv", text),
                     "--split", "0.7", "--tracker-noise", "0.01,0.002", "--out", path("table_model.yaml")});
    EXPECT_EQ(finished.exit_code, 0) << finished.err << finished.out;
  }
  std::vector<std::string> with_table(std::vector<std::string> more) const {
    more.insert(more.begin(), {"--positioner", table_file_, "--positioner-model", path("table_model.yaml"),
                               "--root", kRoot});
    return more;
  }
  std::string workpiece(double slip_mm = 0) {
    std::string text = truth_.joint_count() == 1 ? "point,q1,x,y,z\n" : "point,q1,q2,x,y,z\n";
    for (int i = 0; i < 4; ++i) {
      const JointVector e = turned();
      for (const auto& [name, p_U_mm] :
           {std::pair{"origin", Eigen::Vector3d(0, 0, 0)}, {"x", {350, 0, 0}}, {"xy", {40, 300, 0}}}) {
        Eigen::Vector3d p_F = plain::moved(X_FU_, p_U_mm);
        if (i == 2 && std::string(name) == "x") p_F.y() += slip_mm;
        text += std::string(name) + ',' + row(e, p_F);
      }
    }
    return folder_.write("workpiece.csv", text);
  }
  std::string measured() {
    EXPECT_EQ(
        run("positioner", with_table({"--data", workpiece(), "--out", path("positioner.yaml")})).exit_code,
        0);
    return path("positioner.yaml");
  }

  std::string table_file_;
  RobotModel truth_;
  Eigen::Matrix4d X_BR_ = plain::kuka_frame({1902, 348, -151}, {25.1, 0.2, -0.1});
  Eigen::Matrix4d X_FU_ = plain::kuka_frame({-60, 80, 40}, {35, 2, -1});
};

class PositionerTargets : public PositionerCommand, public testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(Axes, PositionerTargets, testing::Values(kTurntable, kTiltAndTurn));

TEST_P(PositionerTargets, AreReachedOnTheTableWhereverItIsTurned) {
  calibrate_table(GetParam());
  const std::string positioner = measured();
  // Targets that the arm can take, in the workpiece.
  std::string rows = truth_.joint_count() == 1 ? "x,y,z,a,b,c,e1\n" : "x,y,z,a,b,c,e1,e2\n";
  std::vector<Eigen::Matrix4d> wanted;
  for (int i = 0; i < 3; ++i) {
    JointVector q(6), e = turned();
    q << random_.uniform(-0.4, 0.1), random_.uniform(-1.5, -1.1), random_.uniform(1.3, 1.7),
        random_.uniform(-1, 1), random_.uniform(0.6, 1.2), random_.uniform(-1, 1);
    wanted.push_back(plain::flange(nominal_, q));
    const Eigen::Matrix4d X_U = (table_at(e) * X_FU_).inverse() * wanted.back();
    rows += cells(X_U.topRightCorner<3, 1>()) + cells(kuka_abc_deg(X_U.topLeftCorner<3, 3>())) +
            cells(e, kDegPerRad);
    rows.back() = '\n';
  }
  const json::object reached =
      document("compensate", {"--poses", folder_.write("targets.csv", rows), "--positioner", positioner,
                              "--near", "0,-75,85,0,50,0"});
  EXPECT_FALSE(reached.contains("notes"));
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto deg = json::value_to<std::vector<double>>(reached.at("joints").at(i));
    const Eigen::Matrix4d real = plain::flange(model_.cell.robot, joints_from(deg, nominal_));
    EXPECT_LT(plain::mm_between(real, wanted[i]), 0.06) << i;
    EXPECT_LT(plain::rad_between(real, wanted[i]), 2e-4) << i;
    const double sigma_mm = reached.at("sigma_mm").at(i).to_number<double>();
    EXPECT_GT(sigma_mm, std::sqrt(3.0) * kNoise_mm) << "of the arm alone";
    EXPECT_LT(sigma_mm, 0.1);
  }
}

TEST_F(PositionerCommand, ARowThatSlippedEndsItAndWritesNoFile) {
  calibrate_table(kTurntable);
  const Finished finished =
      run("positioner", with_table({"--data", workpiece(0.4), "--out", path("positioner.yaml")}));
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_THAT(finished.err, HasSubstr("workpiece.csv: row 8: more than five standard deviations"));
  EXPECT_FALSE(std::filesystem::exists(path("positioner.yaml")));
}

TEST_F(PositionerCommand, ATrackerThatMovedBeforeTheWorkpieceWasMeasuredIsReported) {
  calibrate_table(kTiltAndTurn);
  const Eigen::Vector3d before_mm = model_.cell.base.p_mm;
  model_.cell.base.p_mm.y() += 0.5;
  const std::string readings = workpiece();
  model_.cell.base.p_mm = before_mm;
  const Finished finished =
      run("positioner", with_table({"--data", readings, "--out", path("positioner.yaml")}));
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_THAT(finished.err, HasSubstr("workpiece.csv: the positioner's root or the tracker stands 0."));
  EXPECT_THAT(finished.err, HasSubstr("from the same station"));
  EXPECT_FALSE(std::filesystem::exists(path("positioner.yaml")));
}

TEST_F(PositionerCommand, ARootFarFromTheGivenOneAsksForTheStationOfTheTracker) {
  calibrate_table(kTurntable);
  model_.cell.base.p_mm.x() += 700;  // the tracker was moved between arm and table
  folder_.write("model.yaml", config::model_yaml(model_));
  const json::object result = document("positioner", with_table({}));
  EXPECT_THAT(std::string(result.at("notes").at(1).as_string()),
              HasSubstr("from one and the same station of the tracker"));
}

TEST_F(PositionerCommand, TellsThatTheTableFailedItsVerdictHereAndWhereItIsUsed) {
  calibrate_table(kTiltAndTurn);
  config::ModelFile table = config::load_model(path("table_model.yaml"));
  table.verdict = CalibrationVerdict{{finding(FindingKind::Tolerance, "it is off by 3 mm")}};
  folder_.write("table_model.yaml", config::model_yaml(table));
  const std::string warning = ": judged red when it was made, do not use it: it is off by 3 mm\n";
  const Finished made =
      run("positioner", with_table({"--data", workpiece(), "--out", path("positioner.yaml")}));
  EXPECT_THAT(made.err, HasSubstr(path("table_model.yaml") + warning));
  const Finished used = run("compensate", {"--positioner", path("positioner.yaml"), "--poses",
                                           folder_.write("t.csv", "x,y,z,e1,e2\n1,2,3,4,5\n")});
  EXPECT_THAT(used.err, HasSubstr(path("positioner.yaml") + ": table" + warning));
}

TEST_F(PositionerCommand, WhatCannotBeUsedIsRefusedWithWhatToDo) {
  calibrate_table(kTiltAndTurn);
  const auto error = [&](const std::string& command, std::vector<std::string> arguments) {
    const Finished finished = run(command, std::move(arguments));
    EXPECT_NE(finished.exit_code, 0);
    return finished.err;
  };
  EXPECT_THAT(error("positioner", {"--positioner", kRobot, "--positioner-model", model_file_}),
              HasSubstr("has 6 joints, a positioner one or two"));
  EXPECT_THAT(
      error("positioner", with_table({"--data", folder_.write("w.csv", "point,q1,q2\norigin,1,2\n")})),
      HasSubstr("the workpiece is measured by the tracker"));
  EXPECT_THAT(error("positioner", with_table({"--data", folder_.write("w.csv", "q1,q2,x,y,z\n1,2,3,4,5\n")})),
              HasSubstr("the points say no frame"));
  EXPECT_THAT(error("positioner", with_table({"--out", path("p.yaml")})), HasSubstr("--data"));
  const std::string positioner = measured();
  EXPECT_THAT(
      error("compensate", {"--positioner", positioner, "--poses", folder_.write("t.csv", "x,y,z\n1,2,3\n")}),
      HasSubstr("e1"));
  EXPECT_THAT(error("compensate", {"--positioner", positioner, "--poses",
                                   folder_.write("t.csv", "x,y,z,e1,e2\n1,2,3,95,0\n")}),
              HasSubstr("the positioner does not go there: expected -90..90"));
  EXPECT_THAT(error("compensate", {"--poses", folder_.write("t.csv", "x,y,z,e1\n1,2,3,95\n")}),
              HasSubstr("e1"));
  model_.created = "2026-02-02T03:04:05Z";
  folder_.write("model.yaml", config::model_yaml(model_));
  EXPECT_THAT(error("compensate", {"--positioner", positioner, "--poses",
                                   folder_.write("t.csv", "x,y,z,e1,e2\n1,2,3,4,5\n")}),
              HasSubstr("run `truepose positioner` with this model again"));
}

}  // namespace
}  // namespace truepose
