// What points say that the flange carried, in the model and where that is used.
#include <gtest/gtest.h>

#include <fstream>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

/// An arm whose second joint bends under what the flange carries.
class Payloads : public testing::Test {
 protected:
  static constexpr const char* kToSayIt =
      "payload_kg, payload_x, payload_y and payload_z of the points say it\n";

  /// @param carried  at one pose after the other, in turn
  /// @param stated   whether the file says so
  std::string measured(const std::string& name, int poses, const std::vector<LinkMass>& carried,
                       bool stated = true) {
    CalibratedCell truth{.robot = nominal_,
                         .base = {.p_mm = {3200, -1450, 780}, .rxyz_rad = {0.01, -0.02, 2.4}},
                         .reflectors = {{"1", {62, -48, 187}}}};
    truth.robot.deviation = {{.joint = 1, .basis = DeviationBasis::Gravity, .order = 1, .coefficient = 4e-4}};
    MeasurementData data{.smr_names = {"1"}};
    for (const JointVector& q : random_poses(nominal_, poses, random_)) {
      Measurement& point = data.points.emplace_back(Measurement{.q = q});
      point.payload = carried[data.points.size() % carried.size()];
      point.p_WS_mm =
          truth.predict(point) + 0.01 * Eigen::Vector3d(random_.normal(), random_.normal(), random_.normal());
      if (!stated) point.payload.reset();
    }
    std::ofstream out(folder_.path() / name);
    config::write_measurements(out, data, nominal_);
    return folder_.path() / name;
  }
  config::ModelFile calibrated(const std::string& data) {
    const Finished run =
        run_program("truepose", {"calibrate", "--robot", kRobot, "--data", data, "--non-geometric", "auto",
                                 "--folds", "5", "--out", model_});
    EXPECT_EQ(run.exit_code, 0) << run.err << run.out;
    return config::load_model(model_);
  }
  std::string drift_says(const std::string& data) {
    return run_program("truepose", {"drift", "--robot", kRobot, "--model", model_, "--data", data}).err;
  }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
  Random random_{20261126};
  std::string model_ = folder_.path() / "model.yaml";
  LinkMass gun_{150, {0, 0, 200}};
};

TEST_F(Payloads, ThatAllPointsSayAreTheModels) {
  const config::ModelFile model = calibrated(measured("data.csv", 60, {gun_}));
  EXPECT_EQ(model.cell.robot.payload, gun_);
  EXPECT_FALSE(model.several_payloads);
  EXPECT_EQ(drift_says(measured("five.csv", 5, {gun_}, false)), "");
}

TEST_F(Payloads, OfWhichThereWereSeveralLeaveOpenWhatIsCarriedNow) {
  const config::ModelFile model = calibrated(measured("data.csv", 60, {gun_, LinkMass{}}));
  EXPECT_FALSE(model.cell.robot.payload);
  EXPECT_TRUE(model.several_payloads);
  EXPECT_EQ(drift_says(measured("payload_given.csv", 5, {gun_})), "");
  EXPECT_EQ(drift_says(measured("untold.csv", 5, {LinkMass{}}, false)),
            model_ +
                ": measured under several payloads, and the arm's load is not given: it is taken to carry "
                "nothing; columns " +
                kToSayIt);
}

}  // namespace
}  // namespace truepose
