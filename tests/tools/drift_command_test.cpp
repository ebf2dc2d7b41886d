#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <filesystem>
#include <fstream>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

namespace json = boost::json;

/// A simulated arm, calibrated by the command line.
class DriftCommand : public testing::Test {
 protected:
  DriftCommand() {
    truth_ = {.robot = with_published_errors(nominal_),
              .p_FS_mm = {80, 40, 120},
              .repeatability_mm = kRepeatability_mm};
    truth_.X_WB.translation() = Eigen::Vector3d(4000, 500, -300);
    const auto identify = random_poses(nominal_, 40, random_), validate = random_poses(nominal_, 20, random_);
    const std::string data =
        write("data.csv", measure_campaign(truth_, identify, validate, {.seed = 1}).data);
    const Finished run =
        run_program("truepose", {"calibrate", "--robot", kRobot, "--data", data, "--out", model_});
    EXPECT_EQ(run.exit_code, 0) << run.err;
  }

  std::string write(const std::string& name, const MeasurementData& data) {
    std::ofstream out(folder_.path() / name);
    config::write_measurements(out, data, nominal_);
    return folder_.path() / name;
  }

  /// Five points as the arm stands now.
  std::string five_points() {
    return write(
        "five.csv",
        measure_campaign(truth_, random_poses(nominal_, 5, random_), {}, {.seed = random_.next()}).data);
  }

  static Finished drift(const std::string& model, const std::string& data,
                        std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"drift", "--robot", kRobot, "--model", model, "--data", data});
    return run_program("truepose", more);
  }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
  TrueArmSetup truth_;
  Random random_{20261121};
  std::string model_ = folder_.path() / "model.yaml";
};

TEST_F(DriftCommand, UpdatesAModelThatIsRightFromThenOnAndNamesTheOldOne) {
  truth_.robot.joints[2].theta_rad += 5e-4;
  const std::string updated = folder_.path() / "updated.yaml";
  const std::string data = five_points();
  const Finished run = drift(model_, data, {"--update", "--out", updated});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("\nupdated:\n  axis 3's zero moved by 0.02"), std::string::npos) << run.out;
  const config::ModelFile old = config::load_model(model_), model = config::load_model(updated);
  EXPECT_EQ(model.updates, "model.yaml of " + old.created);
  EXPECT_GT(model.validation_mean_mm, 0);
  const auto theta = [](const config::ModelFile& file) {
    return *std::ranges::find(file.parameters, "link3.theta", &IdentifiedParameter::name);
  };
  EXPECT_NEAR(theta(model).value - theta(old).value, 5e-4, 5e-5);
  EXPECT_EQ(theta(model).value, model.cell.robot.joints[2].theta_rad);
  EXPECT_GT(theta(model).sigma, 0);
  EXPECT_EQ(drift(model_, five_points()).exit_code, 1);
  EXPECT_NE(drift(updated, five_points()).out.find("\nok: "), std::string::npos);
}

TEST_F(DriftCommand, WritesNoUpdateOfAnUnchangedArmOrByAWrongReading) {
  const std::string updated = folder_.path() / "updated.yaml";
  const Finished unchanged = drift(model_, five_points(), {"--update", "--out", updated});
  EXPECT_EQ(unchanged.exit_code, 0);
  EXPECT_NE(unchanged.out.find("\nnot updated:\n  nothing has moved that the points could show\n"),
            std::string::npos)
      << unchanged.out;
  MeasurementData data = config::load_measurements(five_points(), nominal_);
  data.points[3].p_WS_mm.x() += 2;
  const Finished reading = drift(model_, write("wrong.csv", data), {"--update", "--out", updated, "--json"});
  EXPECT_EQ(reading.exit_code, 0);
  const json::object update = printed_document(reading.out).at("update").as_object();
  EXPECT_EQ(update.at("offered"), false);
  EXPECT_TRUE(
      update.at("rejected").at(0).as_string().starts_with("the reading of point 4 alone is off by 2.0"));
  EXPECT_FALSE(exists(std::filesystem::path{updated}));
}

TEST_F(DriftCommand, JudgesAModelFileOfBeforeByItsValidation) {
  config::ModelFile model = config::load_model(model_);
  ASSERT_TRUE(model.noise);
  EXPECT_GT(model.covariance.size(), 0);
  model.noise.reset();
  model.covariance = {};
  model.validation.clear();
  const std::string old = folder_.write("old.yaml", config::model_yaml(model));
  const std::string data = five_points();
  const Finished run = drift(old, data);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("does not say how well its parameters are known"), std::string::npos) << run.out;

  model.validation_mean_mm = 0;
  const std::string bare = folder_.write("bare.yaml", config::model_yaml(model));
  const Finished refused = drift(bare, data);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.err,
            "truepose: " + bare +
                ": holds no noise and was not validated: state --tracker-noise and --repeatability\n");
  EXPECT_EQ(drift(bare, data, {"--tracker-noise", "0.01,0.003", "--repeatability", "0.017"}).exit_code, 0);
}

TEST_F(DriftCommand, NamesTheRowOfAReflectorThatTheModelDoesNotKnow) {
  const std::string data = folder_.write(
      "five.csv", "q1,q2,q3,q4,q5,q6,x,y,z,smr\n0,-90,90,0,30,0,1,2,3,1\n0,-90,90,0,30,9,1,2,3,other\n");
  const Finished run = drift(model_, data);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err, "truepose: " + data + ": row 2: smr: the model knows no reflector 'other'\n");
}

}  // namespace
}  // namespace truepose
