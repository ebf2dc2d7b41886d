// `truepose calibrate` on the reference points of tests/golden.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "tests/core/golden.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

namespace json = boost::json;

class Offline : public testing::Test {
 protected:
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

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
};

TEST_F(Offline, WhyItFailedStandsBehindTheReportWhereBothGoToOneFile) {
  const Finished run =
      run_into_one_file("truepose", {"calibrate", "--robot", kRobot, "--data", write_golden_points(false)});
  EXPECT_EQ(run.exit_code, 1);
  const std::size_t why = run.out.find("truepose: ");
  ASSERT_NE(why, std::string::npos) << run.out;
  EXPECT_GT(why, run.out.find("Verdict: amber"));
  EXPECT_EQ(run.out.find('\n', why), run.out.size() - 1) << "the last line";
}

TEST_F(Offline, TheDocumentSaysHowAFileOfAnotherProgramWasRead) {
  const std::string own = write_golden_points(true);
  const auto documented = [&](const std::string& file) {
    return succeed({"calibrate", "--robot", kRobot, "--data", file, "--json"});
  };
  EXPECT_FALSE(documented(own).contains("read_as"));
  std::string text = text_of(own);
  std::ranges::replace(text, ',', ';');
  const json::array read_as = documented(folder_.write("semicolons.csv", text)).at("read_as").as_array();
  ASSERT_EQ(read_as.size(), 1);
  EXPECT_TRUE(read_as[0].as_string().ends_with("semicolons.csv: read as: semicolons"));
}

TEST_F(Offline, CalibrateWarnsOfPointsThatAreTheRobotsOwnPositions) {
  const std::string file = write_golden_points(false);
  MeasurementData data = config::load_measurements(file, nominal_);
  for (Measurement& point : data.points)
    point.p_WS_mm = (forward_kinematics(nominal_, point.q).translation() * 100).array().round() / 100;
  std::ofstream out(folder_.path() / "own.csv");
  config::write_measurements(out, data, nominal_);
  out.close();
  const auto warns = [&](const std::string& points) {
    return run_program("truepose", {"calibrate", "--robot", kRobot, "--data", points})
        .err.contains("Give the tracker's readings, not the robot's own positions");
  };
  EXPECT_TRUE(warns(folder_.path() / "own.csv"));
  EXPECT_FALSE(warns(file));
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

}  // namespace
}  // namespace truepose
