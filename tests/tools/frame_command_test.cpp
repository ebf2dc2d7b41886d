// `truepose tool` and `truepose base`, and what takes their files, on an arm whose truth is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "config/frame_file.hpp"
#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/tools/known_arm_command.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

class FrameCommand : public KnownArmCommand {
 protected:
  FrameCommand() : KnownArmCommand{20} {}

  JointVector joints() {
    JointVector q(6);
    q << random_.uniform(-1, 1), random_.uniform(-1.7, -1.1), random_.uniform(1.3, 1.9),
        random_.uniform(-1.5, 1.5), random_.uniform(0.6, 1.2), random_.uniform(-1.5, 1.5);
    return q;
  }
  std::string cells(const JointVector& q) const {
    std::ostringstream text;
    text.precision(17);
    for (const double deg : in_deg_mm(q, nominal_)) text << deg << ',';
    return text.str();
  }
  static std::string cells(const Eigen::Vector3d& p) {
    std::ostringstream text;
    text.precision(17);
    text << p.x() << ',' << p.y() << ',' << p.z();
    return text.str();
  }
  Eigen::Vector3d truly(const JointVector& q, const Eigen::Vector3d& p_T_mm) const {
    return plain::moved(plain::flange(model_.cell.robot, q) * X_FT_, p_T_mm);
  }

  /// A pose of the tool that the arm can take, in a frame.
  Eigen::Matrix4d reachable(const Eigen::Matrix4d& X_B = Eigen::Matrix4d::Identity()) {
    return X_B.inverse() * plain::flange(nominal_, joints()) * X_FT_;
  }
  /// "x,y,z,a,b,c"
  static std::string pose_cells(const Eigen::Matrix4d& X) {
    return cells(Eigen::Vector3d(X.topRightCorner<3, 1>())) + ',' +
           cells(kuka_abc_deg(X.topLeftCorner<3, 3>()));
  }
  Eigen::Matrix4d truly_at(const json::object& reached, std::size_t row) const {
    const auto deg = json::value_to<std::vector<double>>(reached.at("joints").at(row));
    return plain::flange(model_.cell.robot, joints_from(deg, nominal_)) * X_FT_;
  }

  /// Reflectors at origin, x and xy, read in ten orientations.
  std::string seen_tool(double slip_mm = 0) {
    const std::vector<std::pair<const char*, Eigen::Vector3d>> points{
        {"origin", {0, 0, 0}}, {"x", {120, 0, 0}}, {"xy", {-20, 90, 0}}};
    std::string text = "point,q1,q2,q3,q4,q5,q6,x,y,z\n";
    for (int i = 0; i < 10; ++i) {
      const JointVector q = joints();
      for (const auto& [name, p_T_mm] : points) {
        const Eigen::Vector3d p_W = model_.cell.base.isometry() * truly(q, p_T_mm) + noise();
        const bool slips = i == 4 && std::string(name) == "x";
        text += std::string(name) + ',' + cells(q) +
                cells(Eigen::Vector3d(p_W + Eigen::Vector3d(slips ? slip_mm : 0, 0, 0))) + '\n';
      }
    }
    return folder_.write("tool.csv", text);
  }
  /// Joints at which the TCP truly touches a point of the base.
  JointVector touching(const Eigen::Vector3d& p_B_mm) {
    const TargetCompensation truth(nominal_, model_.cell.robot);
    return truth.at_position(p_B_mm + noise(), joints(), X_FT_.topRightCorner<3, 1>())->q;
  }
  std::string measured_tool(int number = 3) {
    EXPECT_EQ(
        run("tool", {"--data", seen_tool(), "--number", std::to_string(number), "--out", path("tool.yaml")})
            .exit_code,
        0);
    return path("tool.yaml");
  }
  /// Four corners of a fixture, whose coordinates in it are known.
  std::string measured_base() {
    std::string text = "point,px,py,pz,q1,q2,q3,q4,q5,q6\n";
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(400, 0, 0),
                                     Eigen::Vector3d(0, 300, 0), Eigen::Vector3d(400, 300, 20)}) {
      const std::string point = "c" + std::to_string(text.size()) + ',' + cells(p) + ',';
      for (int i = 0; i < 2; ++i) {
        std::string q = cells(touching(plain::moved(X_BU_, p)));
        q.back() = '\n';
        text += point + q;
      }
    }
    const Finished finished = run("base", {"--data", folder_.write("base.csv", text), "--tool",
                                           measured_tool(), "--number", "5", "--out", path("base.yaml")});
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    EXPECT_THAT(finished.out, HasSubstr("base 5: 8 readings of 4 points, touched by tool "));
    return path("base.yaml");
  }

  Eigen::Matrix4d X_FT_ = plain::kuka_frame({90, -60, 310}, {35, 62, -140});
  Eigen::Matrix4d X_BU_ = plain::kuka_frame({1500, 150, 700}, {20, 3, -2});
};

Eigen::Matrix4d frame_in(const json::object& document) {
  const json::object& f = document.at("frame").as_object();
  const auto number = [&](const char* key) { return f.at(key).to_number<double>(); };
  return plain::kuka_frame({number("x"), number("y"), number("z")}, {number("a"), number("b"), number("c")});
}

TEST_F(FrameCommand, OneReadingOfA6DTargetTellsTheToolWithItsAxes) {
  const JointVector q = joints();
  const Eigen::Matrix4d X_W =
      model_.cell.base.isometry().matrix() * plain::flange(model_.cell.robot, q) * X_FT_;
  const std::string data = folder_.write(
      "six.csv", "q1,q2,q3,q4,q5,q6,x,y,z,a,b,c,sigma_abc\n" + cells(q) + pose_cells(X_W) + ",0.01\n");
  const json::object tool = document("tool", {"--data", data, "--out", path("tool.yaml")});
  EXPECT_LT((frame_in(tool) - X_FT_).norm(), 1e-3);
  EXPECT_GE(tool.at("sigma_deg").at(0).to_number<double>(), 0.01);
  EXPECT_LT(tool.at("readings").at(0).at("orientation_error_deg").to_number<double>(), 1e-6);
  EXPECT_THAT(run("tool", {"--data", data}).out, HasSubstr("turned by, deg"));
  const auto kept = config::load_tool(path("tool.yaml"), nominal_);
  ASSERT_TRUE(kept.data.readings[0].orientation) << "which another model needs to reckon the tool by";
  const auto again = config::tool_under(*config::measuring_cell(model_), kept);
  ASSERT_TRUE(again) << again.error();
  EXPECT_LT((again->X.matrix() - X_FT_).norm(), 1e-3);
}

TEST_F(FrameCommand, AnOrientationIsOfAToolAlone) {
  const std::string data =
      folder_.write("base.csv", "point,x,y,z,a,b,c,sigma_abc\norigin,1,2,3,4,5,6,0.01\n");
  const Finished finished = run("base", {"--data", data});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err, HasSubstr("unknown column 'a'"));
}

TEST_F(FrameCommand, ATcpThatTouchedOnePointKeepsTheOrientationThatIsGiven) {
  std::string text = "q1,q2,q3,q4,q5,q6\n";
  for (int i = 0; i < 10; ++i) {
    text += cells(touching({1600, 100, 800}));
    text.back() = '\n';
  }
  const std::string file = folder_.write("touched.csv", text);
  const json::object tool = document("tool", {"--data", file, "--orientation", "35,62,-140"});
  EXPECT_LT((frame_in(tool) - X_FT_).norm(), 0.1);
  EXPECT_FALSE(tool.contains("sigma_deg")) << "which was not measured";
  EXPECT_THAT(run("tool", {"--data", file}).out, HasSubstr("A, B, C were not measured"));
}

TEST_F(FrameCommand, ARowThatSlippedEndsItAndWritesNoFile) {
  const Finished finished = run("tool", {"--data", seen_tool(0.4), "--out", path("tool.yaml")});
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_THAT(finished.err, HasSubstr("tool.csv: row 14: more than five standard deviations"));
  EXPECT_FALSE(std::filesystem::exists(path("tool.yaml")));
}

TEST_F(FrameCommand, FilesThatTellNoFrameAreRefusedWithWhatIsMissing) {
  const auto error = [&](const std::string& command, const std::string& text) {
    const Finished finished = run(command, {"--data", folder_.write("bad.csv", text)});
    EXPECT_NE(finished.exit_code, 0);
    return finished.err;
  };
  const std::string q = "1,-80,90,10,45,20";
  EXPECT_THAT(error("tool", "q1,q2,q3,q4,q5,q6\n" + q + "\n"), HasSubstr("at least 4 are needed"));
  EXPECT_THAT(error("base", "point,q1,q2,q3,q4,q5,q6\norigin," + q + "\n"),
              HasSubstr("give the tool that did (--tool)"));
  EXPECT_THAT(error("base", "point,x,y,z\norigin,1,2,3\nx,100,2,3\n"),
              HasSubstr("expected origin, x and xy, or at least three"));
  EXPECT_THAT(error("base", "point,x,y,z\norigin,1,2,3\nx,100,2,3\nxy,200,2,3\n"), HasSubstr("on one line"));
  EXPECT_THAT(error("base", "point,x,y,z,px,py,pz\na,1,2,3,0,0,0\na,1,2,3,0,0,1\n"),
              HasSubstr("another row gives 'a' other coordinates"));
  model_.noise.reset();
  folder_.write("model.yaml", config::model_yaml(model_));
  EXPECT_THAT(error("tool", "q1,q2,q3,q4,q5,q6\n" + q + "\n"), HasSubstr("state --tracker-noise"));
}

TEST_F(FrameCommand, CompensatePutsTheMeasuredTcpThereAndTellsItsSigma) {
  const std::string tool = measured_tool();
  const std::vector<Eigen::Matrix4d> wanted{reachable(), reachable()};
  const std::string poses = folder_.write(
      "poses.csv", "x,y,z,a,b,c\n" + pose_cells(wanted[0]) + '\n' + pose_cells(wanted[1]) + '\n');
  const json::object reached = document("compensate", {"--poses", poses, "--tool", tool});
  EXPECT_FALSE(reached.contains("notes"));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT(plain::mm_between(truly_at(reached, i), wanted[i]), 0.03);
    const double sigma_mm = reached.at("sigma_mm").at(i).to_number<double>();
    EXPECT_GT(sigma_mm, std::sqrt(3.0) * kNoise_mm);
    EXPECT_LT(sigma_mm, 0.04);
  }
  const json::object given = document("compensate", {"--poses", poses, "--tool", "90,-60,310,35,62,-140"});
  EXPECT_THAT(std::string(given.at("notes").at(0).as_string()), HasSubstr("was given, not measured"));
}

/// The arm is as its model here, which the sigma does not know.
TEST_F(FrameCommand, TheTcpIsNoFartherFromWhereItShouldBeInAMeasuredBaseThanSigmaTells) {
  constexpr int kBases = 4, kPoses = 16;
  double missed2 = 0, sigma2 = 0;
  for (int base = 0; base < kBases; ++base) {
    const std::string file = measured_base();
    std::vector<Eigen::Matrix4d> wanted;
    std::string text = "x,y,z,a,b,c\n";
    for (int i = 0; i < kPoses; ++i) {
      wanted.push_back(reachable(X_BU_));
      text += pose_cells(wanted.back()) + '\n';
    }
    const json::object reached = document("compensate", {"--poses", folder_.write("poses.csv", text),
                                                         "--tool", path("tool.yaml"), "--base", file});
    for (std::size_t i = 0; i < kPoses; ++i) {
      const Eigen::Vector3d repeats = noise();  // which truly_at() does without
      missed2 +=
          std::pow(plain::mm_between(truly_at(reached, i), X_BU_ * wanted[i]), 2) + repeats.squaredNorm();
      sigma2 += std::pow(reached.at("sigma_mm").at(i).to_number<double>(), 2);
    }
  }
  EXPECT_LT(missed2, sigma2);
}

TEST_F(FrameCommand, ATurnOfTheBaseThatIsNotKnownCountsTheMoreTheFartherAway) {
  const std::string base = measured_base();
  const Eigen::Matrix4d wanted = reachable(X_BU_);
  const std::string poses = folder_.write("poses.csv", "x,y,z,a,b,c\n" + pose_cells(wanted) + '\n');
  const auto sigma_mm = [&](double turn_rad) {
    config::BaseFile file = config::load_base(base, model_);
    file.covariance = PoseCovariance::Zero();
    (*file.covariance)(5, 5) = turn_rad * turn_rad;
    folder_.write("base.yaml", config::base_yaml(file));
    const json::object reached =
        document("compensate", {"--poses", poses, "--tool", path("tool.yaml"), "--base", base});
    return reached.at("sigma_mm").at(0).to_number<double>();
  };
  const Eigen::Vector3d arm_mm = (X_BU_ * wanted - X_BU_).topRightCorner<3, 1>();
  const double across_mm = 1e-3 * std::hypot(arm_mm.x(), arm_mm.y());
  EXPECT_NEAR(std::pow(sigma_mm(1e-3), 2) - std::pow(sigma_mm(0), 2), across_mm * across_mm, 1e-4);
}

TEST_F(FrameCommand, AToolOfAnotherArmIsRefused) {
  const std::string poses = folder_.write("poses.csv", "x,y,z,a,b,c\n" + pose_cells(reachable(X_BU_)) + '\n');
  config::ToolFile tool = config::load_tool(measured_tool(), nominal_);
  tool.serial = "768034";
  folder_.write("tool.yaml", config::tool_yaml(tool));
  model_.serial = "768035";
  folder_.write("model.yaml", config::model_yaml(model_));
  const Finished finished = run("compensate", {"--poses", poses, "--tool", path("tool.yaml")});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err,
              HasSubstr("tool.yaml: the tool was measured on arm 768034, but the model is of arm 768035"));
}

TEST_F(FrameCommand, ABaseThatDoesNotTellItsUncertaintyIsNoted) {
  const std::string poses = folder_.write("poses.csv", "x,y,z,a,b,c\n" + pose_cells(reachable(X_BU_)) + '\n');
  const json::object reached =
      document("compensate", {"--poses", poses, "--tool", measured_tool(), "--base", "1500,150,700,20,3,-2"});
  EXPECT_THAT(std::string(reached.at("notes").at(0).as_string()), HasSubstr("--base has no uncertainty"));
}

TEST_F(FrameCommand, ABaseOfAnotherModelIsRefused) {
  const std::string base = measured_base();
  model_.created = "2026-02-02T03:04:05Z";
  folder_.write("model.yaml", config::model_yaml(model_));
  const Finished finished =
      run("compensate", {"--poses", folder_.write("p.csv", "x,y,z\n1,2,3\n"), "--base", base});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err, HasSubstr("base.yaml:"));
  EXPECT_THAT(finished.err, HasSubstr("run `truepose base` with this model again"));
}

TEST_F(FrameCommand, AToolThatTheProgramDoesNotUseIsRefused) {
  const std::string src = folder_.write(
      "p.src", "DEF p()\nBAS(#TOOL,0)\nBAS(#BASE,0)\nPTP {A1 0,A2 -80,A3 90,A4 0,A5 50,A6 0}\nEND\n");
  const Finished finished = run("compensate", {"--program", src, "--tool", measured_tool()});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err, HasSubstr("--tool: is of TOOL_DATA[3], which no motion of the program uses"));
}

/// The controller's tool and base may be wrong.
TEST_F(FrameCommand, AProgramsPointsAreReachedByTheMeasuredToolInTheMeasuredBase) {
  const std::string base = measured_base();
  const std::string config = folder_.write("config.dat",
                                           "DEFDAT $CONFIG\n"
                                           "TOOL_DATA[3]={X 91.5,Y -60.0,Z 309.0,A 35.0,B 62.0,C -140.0}\n"
                                           "BASE_DATA[5]={X 1499.0,Y 150.5,Z 700.0,A 20.0,B 3.0,C -2.1}\n"
                                           "ENDDAT\n");
  const JointVector taught = joints();
  const Eigen::Matrix4d point = X_BU_.inverse() * plain::flange(nominal_, taught) * X_FT_;
  const Eigen::Vector3d p = point.topRightCorner<3, 1>(), abc = kuka_abc_deg(point.topLeftCorner<3, 3>());
  const std::string src = folder_.write(
      "p.src", formatted("DEF p()\nBAS(#TOOL,3)\nBAS(#BASE,5)\nPTP {A1 0,A2 -80,A3 90,A4 0,A5 50,A6 0}\n"
                         "PTP {X %.9f,Y %.9f,Z %.9f,A %.9f,B %.9f,C %.9f}\nEND\n",
                         p.x(), p.y(), p.z(), abc.x(), abc.y(), abc.z()));
  const Finished finished = run("compensate", {"--program", src, "--config-dat", config, "--tool",
                                               path("tool.yaml"), "--base", base, "--out", path("out.src")});
  ASSERT_EQ(finished.exit_code, 0) << finished.err << finished.out;
  double v[6];
  const std::string out = text_of(path("out.src"));
  ASSERT_EQ(std::sscanf(out.c_str() + out.find("PTP {X"), "PTP {X %lf,Y %lf,Z %lf,A %lf,B %lf,C %lf", &v[0],
                        &v[1], &v[2], &v[3], &v[4], &v[5]),
            6);
  // What the controller makes of it by its own frames, and where the true arm then puts the true tool.
  const Eigen::Matrix4d controller_tool = plain::kuka_frame({91.5, -60, 309}, {35, 62, -140}),
                        controller_base = plain::kuka_frame({1499, 150.5, 700}, {20, 3, -2.1});
  const Eigen::Isometry3d X_BF(controller_base * plain::kuka_frame({v[0], v[1], v[2]}, {v[3], v[4], v[5]}) *
                               controller_tool.inverse());
  const auto q = TargetCompensation(nominal_, nominal_).at_pose(X_BF, taught);
  ASSERT_TRUE(q);
  const Eigen::Matrix4d real = plain::flange(model_.cell.robot, q->q) * X_FT_;
  EXPECT_LT(plain::mm_between(real, X_BU_ * point), 0.06);
}

}  // namespace
}  // namespace truepose
