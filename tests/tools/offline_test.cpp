// The offline commands on the reference values of tests/golden.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/number_text.hpp"
#include "config/robot_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "tests/core/golden.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"
#include "tests/tools/unmarked.hpp"

namespace truepose {
namespace {

namespace json = boost::json;

class Offline : public testing::Test {
 protected:
  std::string write_joints(const std::vector<JointVector>& joints) {
    std::ofstream out(folder_.path() / "joints.csv");
    config::write_joints(out, joints, nominal_);
    return folder_.path() / "joints.csv";
  }

  /// The arm with the errors of the reference values.
  std::string write_model(const RobotModel& robot) {
    config::ModelFile model{.name = nominal_.name, .cell = {.robot = robot}};
    return folder_.write("model.yaml", config::model_yaml(model));
  }

  std::string write_golden_points(bool validate) {
    MeasurementData data{.smr_names = {"1"}};
    const json::object golden = golden::load("identify");
    const json::value& set = golden.at("datasets").at(0);
    const auto add = [&](const char* key, PoseSet pose_set) {
      for (const json::value& point : set.at(key).as_array()) {
        data.points.push_back({.q = golden::vector(point.at("q")),
                               .p_WS_mm = golden::vector(point.at("measured")),
                               .set = pose_set});
      }
    };
    add("identification", PoseSet::Identify);
    if (validate) add("validation", PoseSet::Validate);
    std::ofstream out(folder_.path() / "data.csv");
    config::write_measurements(out, data, nominal_);
    return folder_.path() / "data.csv";
  }

  /// Runs a command that must succeed, and reads its document.
  static json::object succeed(const std::vector<std::string>& arguments) {
    const Finished run = run_program("truepose", arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    return printed_document(run.out).as_object();
  }

  static double mean_mm(const json::object& document, const char* set, const char* stage) {
    return document.at(set).at(stage).at("mean").to_number<double>();
  }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
};

TEST_F(Offline, FkGivesTheGoldenPosesOfTheNominalAndOfACalibratedArm) {
  const json::object golden = golden::load("fk");
  const json::value& perturbed = golden.at("parameter_sets").at("perturbed");
  std::vector<JointVector> joints;
  for (const json::value& item : golden.at("cases").as_array())
    joints.push_back(golden::vector(item.at("q")));
  const std::string joints_file = write_joints(joints);
  const std::string model = write_model(golden::robot(perturbed.at("links"), perturbed.at("sign")));

  const json::object of_nominal = succeed({"fk", "--robot", kRobot, "--joints", joints_file, "--json"});
  const json::object of_model =
      succeed({"fk", "--robot", kRobot, "--model", model, "--joints", joints_file, "--json"});
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const json::value& item = golden.at("cases").at(i);
    for (const auto& [document, key] :
         {std::pair{&of_nominal, "nominal"}, std::pair{&of_model, "perturbed"}}) {
      const Eigen::VectorXd pose = golden::vector(document->at("poses").at(i));
      ASSERT_EQ(pose.size(), 16);
      const Eigen::MatrixXd expected = golden::matrix(item.at(key));
      const Eigen::Matrix4d found = pose.reshaped<Eigen::RowMajor>(4, 4);
      EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-9) << key << " " << i;
    }
  }
}

TEST_F(Offline, CompensateGivesTheGoldenJointsAndReachesTheGoldenPoses) {
  const json::object golden = golden::load("compensate");
  const RobotModel calibrated = golden::robot(golden.at("perturbed_links"), golden.at("sign"));
  const std::string model = write_model(calibrated);
  const json::array& cases = golden.at("cases").as_array();
  std::vector<JointVector> joints;
  std::vector<Eigen::Isometry3d> targets;
  std::string poses = "x,y,z,a,b,c\n";
  const Eigen::Vector3d p_FT = golden::vector(golden.at("tool"));
  for (const json::value& item : cases) {
    joints.push_back(golden::vector(item.at("q_nominal")));
    Eigen::Isometry3d X(Eigen::Matrix4d(golden::matrix(item.at("target_tool_pose"))));
    X.translation() -= X.linear() * p_FT;
    targets.push_back(X);
    const Eigen::Vector3d abc = kuka_abc_deg(X.linear());
    for (const double number : {X(0, 3), X(1, 3), X(2, 3), abc.x(), abc.y()})
      poses += config::format_number(number) + ",";
    poses += config::format_number(abc.z()) + "\n";
  }

  const std::string out = folder_.path() / "out.csv";
  const json::object by_joints = succeed({"compensate", "--robot", kRobot, "--model", model, "--joints",
                                          write_joints(joints), "--out", out, "--json"});
  ASSERT_EQ(by_joints.at("joints").as_array().size(), cases.size());
  ASSERT_EQ(by_joints.at("iterations").as_array().size(), cases.size());
  const std::vector<JointVector> written = config::load_joints(out, nominal_);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Eigen::VectorXd q = golden::vector(by_joints.at("joints").at(i)) * kRadPerDeg;
    EXPECT_LT((q - golden::vector(cases[i].at("q_compensated"))).cwiseAbs().maxCoeff(), 1e-10) << i;
    EXPECT_LT((q - written[i]).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_LT(by_joints.at("residual_mm").at(i).to_number<double>(), 1e-9);
  }

  const json::object by_poses = succeed({"compensate", "--robot", kRobot, "--model", model, "--poses",
                                         folder_.write("poses.csv", poses), "--json"});
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const JointVector q = golden::vector(by_poses.at("joints").at(i)) * kRadPerDeg;
    const Eigen::Isometry3d X = forward_kinematics(calibrated, q);
    EXPECT_LT((X.translation() - targets[i].translation()).norm(), 1e-8) << i;
    EXPECT_LT(angle_between(X.linear(), targets[i].linear()), 1e-10) << i;
  }
}

TEST_F(Offline, CompensatePrintsJointsThatCanBeReadBack) {
  const std::string joints = write_joints({(JointVector(6) << 0.1, -1.5, 1.4, 0.2, 0.6, 0).finished()});
  const Finished run = run_program(
      "truepose", {"compensate", "--robot", kRobot, "--model", write_model(nominal_), "--joints", joints});
  EXPECT_EQ(run.exit_code, 0);
  const auto printed = config::load_joints(folder_.write("printed.csv", run.out), nominal_);
  ASSERT_EQ(printed.size(), 1U);
  EXPECT_NEAR(printed[0][1], -1.5, 1e-12);
}

TEST_F(Offline, AnUnreachablePoseIsAnErrorThatNamesItsRow) {
  const std::string poses =
      folder_.write("poses.csv", "x,y,z,a,b,c\n1765,0,1910,0,90,0\n9000,0,1910,0,90,0\n");
  const std::string out = folder_.path() / "out.csv";
  const Finished run =
      run_program("truepose", {"compensate", "--robot", kRobot, "--model", write_model(nominal_), "--poses",
                               poses, "--out", out, "--json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "truepose: " + poses + ": row 2: the pose is out of the arm's reach\n");
  EXPECT_EQ(run.out, "");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(Offline, ATargetBeyondAJointLimitNamesItsRowAndTheJoint) {
  const std::string joints =
      folder_.write("joints.csv", "q1,q2,q3,q4,q5,q6\n0,-90,90,0,30,0\n0,-90,90,0,30,351\n");
  const Finished run = run_program(
      "truepose", {"compensate", "--robot", kRobot, "--model", write_model(nominal_), "--joints", joints});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(
      run.err,
      "truepose: " + joints +
          ": row 2: joint 6 would have to go to 351 deg, its limits are -350..350; move it away from the limit\n");
}

TEST_F(Offline, AModelOfAnotherArmIsRefused) {
  const std::string model =
      folder_.write("model.yaml", config::model_yaml({.name = "another arm", .cell = {.robot = nominal_}}));
  const Finished run =
      run_program("truepose", {"fk", "--robot", kRobot, "--model", model, "--joints", write_joints({})});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err, "truepose: " + model +
                         ": the model of 'another arm' with 6 joints, but the robot file is of '" +
                         nominal_.name + "' with 6\n");
}

TEST_F(Offline, CalibrateFindsTheGoldenArmWithoutNoise) {
  const std::string model = folder_.path() / "model.yaml", report = folder_.path() / "report.html";
  const json::object document = succeed({"calibrate", "--robot", kRobot, "--data", write_golden_points(true),
                                         "--out", model, "--report", report, "--json"});
  EXPECT_TRUE(document.at("converged").as_bool());
  EXPECT_EQ(document.at("rank"), 27);
  EXPECT_EQ(document.at("parameters").as_array().size(), 39U);
  EXPECT_LE(document.at("iterations").at("fine").to_number<int>(), 4);
  EXPECT_EQ(document.at("validate").at("poses"), 30);
  EXPECT_GT(mean_mm(document, "validate", "before"), 1);
  EXPECT_LT(mean_mm(document, "validate", "geometric"), 1e-8);
  EXPECT_EQ(mean_mm(document, "validate", "after"), mean_mm(document, "validate", "geometric"));
  EXPECT_GT(std::filesystem::file_size(report), 1000U);

  // The model predicts the validation points to the last digit that the document shows.
  const config::ModelFile read = config::load_model(model);
  EXPECT_EQ(read.name, nominal_.name);
  EXPECT_DOUBLE_EQ(read.validation_mean_mm, mean_mm(document, "validate", "after"));
  const MeasurementData data = config::load_measurements(folder_.path() / "data.csv", nominal_);
  EXPECT_LT((read.cell.predict(data.points[45].q, 0) - data.points[45].p_WS_mm).norm(), 1e-8);
}

TEST_F(Offline, CalibrateSaysWhenNothingWasValidated) {
  const std::string data = write_golden_points(false);
  const Finished run = run_program("truepose", {"calibrate", "--robot", kRobot, "--data", data});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.out.find("Verdict: amber"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("nothing but the points that it was fitted to"), std::string::npos) << run.err;
}

TEST_F(Offline, WhyItFailedStandsBehindTheReportWhereBothGoToOneFile) {
  const Finished run =
      run_into_one_file("truepose", {"calibrate", "--robot", kRobot, "--data", write_golden_points(false)});
  EXPECT_EQ(run.exit_code, 1);
  const std::size_t why = run.out.find("truepose: ");
  ASSERT_NE(why, std::string::npos) << run.out;
  EXPECT_GT(why, run.out.find("Verdict: amber"));
  EXPECT_EQ(run.out.find('\n', why), run.out.size() - 1) << "the last line";
}

TEST_F(Offline, CalibrateTakesA6DTargetAndTellsHowItIsTurned) {
  const std::string reflector = write_golden_points(true);
  MeasurementData data = config::load_measurements(reflector, nominal_);
  const json::object plain = succeed({"calibrate", "--robot", kRobot, "--data", reflector, "--json"});
  EXPECT_FALSE(plain.contains("targets"));
  EXPECT_FALSE(plain.at("validate").as_object().contains("orientation_errors"));

  const std::string model = folder_.path() / "model.yaml";
  succeed({"calibrate", "--robot", kRobot, "--data", reflector, "--out", model, "--json"});
  const CalibratedCell cell = config::load_model(model).cell;
  const Eigen::Matrix3d R_FT = rotation_by({0.3, -0.8, 1.9});
  Random random{7};
  for (Measurement& point : data.points) {
    point.orientation = MeasuredOrientation{
        cell.base.isometry().linear() * forward_kinematics(cell.robot, point.q).linear() * R_FT, 1e-4};
    for (double& mm : point.p_WS_mm) mm += 0.02 * random.normal();
  }
  std::ofstream out(folder_.path() / "six.csv");
  config::write_measurements(out, data, nominal_);
  out.close();
  std::vector<std::string> arguments{"calibrate", "--robot", kRobot, "--data", folder_.path() / "six.csv"};
  const Finished unweighed = run_program("truepose", arguments);
  EXPECT_EQ(unweighed.exit_code, 2);
  EXPECT_NE(unweighed.err.find("noise"), std::string::npos) << unweighed.err;

  arguments.insert(arguments.end(), {"--tracker-noise", "0.001,0.0001", "--repeatability", "0.02"});
  const Finished text = run_program("truepose", arguments);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("rientation"), std::string::npos) << text.out;
  const std::string report = folder_.path() / "report.html";
  arguments.insert(arguments.end(), {"--report", report, "--json"});
  const json::object document = succeed(arguments);
  EXPECT_NE(text_of(report).find("Orientation of 6-D targets, before and after"), std::string::npos);
  const json::object& turns = document.at("validate").at("orientation_errors").as_object();
  EXPECT_GT(turns.at("before").at("mean_rad").to_number<double>(), 1e-3);
  EXPECT_LT(turns.at("after").at("mean_rad").to_number<double>(), 1e-4);
  const json::object& target = document.at("targets").at(0).as_object();
  const auto turn = [&](const char* key) { return target.at(key).to_number<double>(); };
  EXPECT_LT(angle_between(rotation_zyx(turn("rz"), turn("ry"), turn("rx")), R_FT), 1e-3);
}

TEST_F(Offline, CalibrateValidatesOnAnotherFile) {
  const std::string data = write_golden_points(true);
  const json::object document =
      succeed({"calibrate", "--robot", kRobot, "--data", data, "--validate", data, "--json"});
  EXPECT_EQ(document.at("identify").at("poses"), 30);
  EXPECT_EQ(document.at("validate").at("points"), 60);
}

TEST_F(Offline, CalibrateRefusesAReflectorThatOnlyTheValidationKnows) {
  const std::string data = write_golden_points(false);
  const std::string other =
      folder_.write("v.csv", "q1,q2,q3,q4,q5,q6,x,y,z,smr\n0,-90,90,0,0,0,1,2,3,left\n");
  const Finished run =
      run_program("truepose", {"calibrate", "--robot", kRobot, "--data", data, "--validate", other});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "truepose: " + other + ": smr: reflector 'left' has no points in the data to identify\n");
}

TEST_F(Offline, CalibrateSplitsBySeedAndAveragesRepeats) {
  const std::string data = folder_.write("all.csv", unmarked(text_of(write_golden_points(true))));
  const std::vector<std::string> base{"calibrate", "--robot", kRobot,   "--data", data,
                                      "--split",   "0.7",     "--json", "--seed"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), base.begin(), base.end());
    return succeed(more);
  };
  const json::object first = with({"3"}), again = with({"3"}), second = with({"4"}),
                     both = with({"3", "--repeat", "2"});
  EXPECT_EQ(first.at("identify").at("poses"), 42);
  EXPECT_EQ(first.at("validate").at("poses"), 18);
  EXPECT_EQ(mean_mm(first, "validate", "before"), mean_mm(again, "validate", "before"));
  EXPECT_NE(mean_mm(first, "validate", "before"), mean_mm(second, "validate", "before"));
  ASSERT_EQ(both.at("splits").as_array().size(), 2U);
  EXPECT_EQ(both.at("splits").at(1).at("seed"), 4);
  EXPECT_EQ(both.at("splits").at(1).at("validate"), second.at("validate"));
  EXPECT_DOUBLE_EQ(mean_mm(both, "validate", "before"),
                   (mean_mm(first, "validate", "before") + mean_mm(second, "validate", "before")) / 2);
  EXPECT_EQ(both.at("validate").at("poses"), 18);
}

}  // namespace
}  // namespace truepose
