// An arm with errors in every layer, from its measurements through the model file to commanded joints.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/process.hpp"
#include "tests/sanitized.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

namespace json = boost::json;

// Under a sanitizer the search among all fields takes minutes.
constexpr const char* kResidual = TRUEPOSE_SANITIZED ? "gp" : "auto";

/// Displacement of the flange that no joint's deviation explains. Base frame, mm.
Eigen::Vector3d bent(const JointVector& q) {
  return {0.5 * std::sin(q[0]) * std::cos(q[1]), 0.4 * std::cos(2 * q[0]), 0.5 * std::sin(q[1] + q[2])};
}

class Layers : public testing::Test {
 protected:
  /// Where the flange of the real arm stands.
  Eigen::Isometry3d real_flange(const JointVector& q) const {
    Eigen::Isometry3d X = forward_kinematics(real_, q);
    X.translation() += bent(q);
    return X;
  }

  void measure(int poses, PoseSet set, Random& random) {
    const Eigen::Isometry3d X_WB = base_.isometry();
    for (const JointVector& q : random_poses(nominal_, poses, random)) {
      const Eigen::Vector3d noise_mm(random.normal(), random.normal(), random.normal());
      data_.points.push_back(
          {.q = q, .p_WS_mm = X_WB * (real_flange(q) * p_FS_mm_) + 0.01 * noise_mm, .set = set});
    }
  }

  std::string write_measurements() {
    Random random{20260417};
    measure(90, PoseSet::Identify, random);
    measure(20, PoseSet::Validate, random);
    std::ofstream out(folder_.path() / "data.csv");
    config::write_measurements(out, data_, nominal_);
    return folder_.path() / "data.csv";
  }

  json::object succeed(const std::vector<std::string>& arguments) {
    const Finished run = run_program("truepose", arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return printed_document(run.out).as_object();
  }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
  RobotModel real_ = [this] {
    RobotModel robot = nominal_;
    robot.joints[1].a_mm += 0.6;
    robot.joints[2].d_mm += 0.4;
    robot.joints[4].theta_rad += 1e-3;
    robot.torque_joints = nominal_.joints;
    robot.deviation = {{.joint = 1, .basis = DeviationBasis::Weight, .order = 4, .coefficient = 4e-4},
                       {.joint = 2, .basis = DeviationBasis::Sine, .order = 2, .coefficient = 3e-4}};
    return robot;
  }();
  BasePose base_{.p_mm = {3200, -1450, 780}, .rxyz_rad = {0.01, -0.02, 2.4}};
  Eigen::Vector3d p_FS_mm_{62, -48, 187};
  MeasurementData data_{.smr_names = {"1"}};
};

double mean_error_mm(const CalibratedCell& cell, std::span<const Measurement> points) {
  double sum = 0;
  int count = 0;
  for (const Measurement& point : points) {
    if (point.set != PoseSet::Validate) continue;
    sum += (cell.predict(point.q, 0) - point.p_WS_mm).norm();
    ++count;
  }
  return sum / count;
}

TEST_F(Layers, OfACalibratedArmReachTheModelFileTheForwardKinematicsAndTheCompensation) {
  const std::string data = write_measurements(), model = folder_.path() / "model.yaml";
  const json::object document = succeed({"calibrate", "--robot", kRobot, "--data", data, "--non-geometric",
                                         "auto", "--residual", kResidual, "--out", model, "--json"});
  const auto mean_mm = [&](const char* stage) {
    return document.at("validate").at(stage).at("mean").to_number<double>();
  };
  EXPECT_LT(mean_mm("after"), mean_mm("geometric") / 2);

  const config::ModelFile read = config::load_model(model);
  const RobotModel& calibrated = read.cell.robot;
  EXPECT_FALSE(calibrated.deviation.empty());
  ASSERT_TRUE(calibrated.field);
  EXPECT_DOUBLE_EQ(read.validation_mean_mm, mean_mm("after"));
  const MeasurementData kept = config::load_measurements(data, nominal_);
  EXPECT_NEAR(mean_error_mm(read.cell, kept.points), mean_mm("after"), 1e-9);

  Random random{20260418};
  std::vector<JointVector> joints;
  for (JointVector q : random_poses(nominal_, 20, random)) {
    q = 0.9 * q;  // leaves room for the correction
    q[1] -= 0.1;
    joints.push_back(q);
  }
  const std::string joints_file = folder_.path() / "joints.csv";
  std::ofstream out(joints_file);
  config::write_joints(out, joints, nominal_);
  out.close();

  const json::object poses =
      succeed({"fk", "--robot", kRobot, "--model", model, "--joints", joints_file, "--json"});
  const json::object compensated = succeed({"compensate", "--robot", kRobot, "--model", model, "--joints",
                                            joints_file, "--singularity-threshold", "0", "--json"});
  double uncorrected_mm = 0, corrected_mm = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto pose = json::value_to<std::vector<double>>(poses.at("poses").at(i));
    const Eigen::Matrix4d expected = forward_kinematics(calibrated, joints[i]).matrix();
    for (int k = 0; k < 16; ++k) {
      EXPECT_NEAR(pose[static_cast<std::size_t>(k)], expected(k / 4, k % 4), 1e-9);
    }
    const auto q_deg = json::value_to<std::vector<double>>(compensated.at("joints").at(i));
    const JointVector q = kRadPerDeg * Eigen::Map<const Eigen::VectorXd>(q_deg.data(), 6);
    const Eigen::Isometry3d target = forward_kinematics(nominal_, joints[i]);
    const Eigen::Isometry3d reached = forward_kinematics(calibrated, q);
    EXPECT_LT((reached.translation() - target.translation()).norm(), 1e-8) << i;
    EXPECT_LT(angle_between(reached.linear(), target.linear()), 1e-10) << i;
    uncorrected_mm += (real_flange(joints[i]) * p_FS_mm_ - target * p_FS_mm_).norm() / 20;
    corrected_mm += (real_flange(q) * p_FS_mm_ - target * p_FS_mm_).norm() / 20;
  }
  EXPECT_LT(corrected_mm, uncorrected_mm / 4);
}

/// An arm whose second joint bends under what the flange carries.
class Payloads : public testing::Test {
 protected:
  static constexpr const char* kToSayIt =
      "payload_kg, payload_x, payload_y and payload_z of the points say it\n";

  /// @param carried  at one pose after the other, in turn
  /// @param tells    whether the file says so
  std::string measured(const std::string& name, int poses, const std::vector<LinkMass>& carried,
                       bool tells = true) {
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
      if (!tells) point.payload.reset();
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
