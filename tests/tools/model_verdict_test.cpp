// A model file has the verdict of its calibration, and commands that use it report the verdict.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/number_text.hpp"
#include "config/robot_file.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/known_model.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

constexpr double kScatter_mm = 0.02;

class ModelVerdict : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path() / name; }

  std::string write_model(const std::optional<CalibrationVerdict>& verdict) {
    model_.verdict = verdict;
    return folder_.write("model.yaml", config::model_yaml(model_));
  }

  /// What a command says on standard error of the model that it works with.
  static std::string said(std::vector<std::string> words) {
    const Finished run = run_program("truepose", words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err;
  }

  /// Points of the model's own arm.
  std::string measured(const std::string& name, int poses, double zero_moved_rad = 0) {
    CalibratedCell cell = model_.cell;
    cell.robot.joints[2].theta_rad += zero_moved_rad;
    MeasurementData data{.smr_names = {"1"}};
    for (const JointVector& q : random_poses(nominal_, poses, random_)) {
      const Eigen::Vector3d noise_mm(random_.normal(), random_.normal(), random_.normal());
      data.points.push_back({.q = q, .p_WS_mm = cell.predict(q, 0) + kScatter_mm * noise_mm});
    }
    std::ofstream out(path(name));
    config::write_measurements(out, data, nominal_);
    return path(name);
  }

  TempFolder folder_;
  Random random_{20261126};
  RobotModel nominal_ = config::load_robot(kRobot);
  config::ModelFile model_ = known_model(nominal_, kScatter_mm);
  std::string joints_ = folder_.write("joints.csv", "q1,q2,q3,q4,q5,q6\n20,-80,100,30,45,-40\n");
};

TEST_F(ModelVerdict, IsReportedByEveryCommandThatWorksWithAModelThatFailedIt) {
  const std::string model =
      write_model(CalibrationVerdict{{finding(FindingKind::Tolerance, "the largest error is 3 mm"),
                                      finding(FindingKind::BelowNoise, "and")}});
  const std::string warning =
      model + ": judged red when it was made, do not use it: the largest error is 3 mm\n";
  EXPECT_EQ(said({"fk", "--robot", kRobot, "--model", model, "--joints", joints_}), warning);
  EXPECT_EQ(said({"compensate", "--robot", kRobot, "--model", model, "--joints", joints_}), warning);
  EXPECT_EQ(said({"export", "--model", model, "--csv", path("p.csv")}),
            warning + path("p.csv") + ": written\n");
  EXPECT_EQ(said({"drift", "--robot", kRobot, "--model", model, "--data", measured("five.csv", 5)}), warning);
  std::string cycles = "point,cycle,x,y,z\n", targets = "point,x,y,z\n";
  for (int point = 1; point <= 5; ++point) {
    targets += "P" + std::to_string(point) + ",1700," + std::to_string(100 * point) + ",900\n";
    for (int cycle = 1; cycle <= 3; ++cycle) {
      const Eigen::Vector3d p_W_mm =
          model_.cell.base.isometry() * Eigen::Vector3d(1700, 100 * point, 900 + cycle);
      cycles += "P" + std::to_string(point) + "," + std::to_string(cycle);
      for (const double mm : p_W_mm) cycles += "," + config::format_number(mm);
      cycles += "\n";
    }
  }
  EXPECT_EQ(said({"iso9283", "--data", folder_.write("cycles.csv", cycles), "--targets",
                  folder_.write("targets.csv", targets), "--model", model}),
            warning);
}

TEST_F(ModelVerdict, IsReportedWithItsDoubtAndNotWhereNothingFailed) {
  const auto fk = [this](const std::string& model) {
    return said({"fk", "--robot", kRobot, "--model", model, "--joints", joints_});
  };
  const std::string model =
      write_model(CalibrationVerdict{{finding(FindingKind::FewValidated, "2 poses say little")}});
  EXPECT_EQ(
      fk(model),
      model + ": judged amber when it was made, look into that before you use it: 2 poses say little\n");
  EXPECT_EQ(fk(write_model(CalibrationVerdict{{finding(FindingKind::LeavesSome, "some is left")}})), "");
  EXPECT_EQ(fk(write_model(CalibrationVerdict{})), "");
  EXPECT_EQ(fk(write_model(std::nullopt)), "");
}

TEST_F(ModelVerdict, IsWhatCalibrateFound) {
  const std::string data = measured("data.csv", 40);
  const auto calibrate = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"calibrate", "--robot", kRobot, "--data", data, "--split", "0.7",
                               "--repeatability", "0.02", "--out", path("made.yaml")});
    return run_program("truepose", more);
  };
  EXPECT_EQ(calibrate({}).exit_code, 0);
  ASSERT_TRUE(config::load_model(path("made.yaml")).verdict);
  EXPECT_EQ(config::load_model(path("made.yaml")).verdict->color(), VerdictColor::Green);

  const Finished refused = calibrate({"--tolerance", "0.001"});
  EXPECT_EQ(refused.exit_code, 1);
  const config::ModelFile made = config::load_model(path("made.yaml"));
  EXPECT_EQ(made.verdict->color(), VerdictColor::Red);
  const std::string why = made.verdict->findings.front().sentence;
  EXPECT_TRUE(why.contains("beyond the tolerance of 0.001 mm")) << why;
  EXPECT_EQ(refused.err, path("made.yaml") + ": written\ntruepose: " + data + ": " + why +
                             ". Add layers or poses, or allow more.\n");
  EXPECT_EQ(said({"fk", "--robot", kRobot, "--model", path("made.yaml"), "--joints", joints_}),
            path("made.yaml") + ": judged red when it was made, do not use it: " + why + "\n");
}

TEST_F(ModelVerdict, StaysWithAModelThatIsBroughtUpToDate) {
  const CalibrationVerdict red{{finding(FindingKind::Tolerance, "the largest error is 3 mm")}};
  const std::string model = write_model(red);
  const Finished run =
      run_program("truepose", {"drift", "--robot", kRobot, "--model", model, "--data",
                               measured("moved.csv", 8, 1e-3), "--update", "--out", path("updated.yaml")});
  EXPECT_EQ(run.exit_code, 0) << run.err << run.out;
  const auto kept = config::load_model(path("updated.yaml")).verdict;
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->findings.front().sentence, "the largest error is 3 mm");
}

}  // namespace
}  // namespace truepose
