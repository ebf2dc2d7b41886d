#pragma once

#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/calibrate/calibrate.hpp"
#include "core/frames/positioner.hpp"
#include "core/frames/tool_frame.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/frame_errors.hpp"
#include "tests/core/plain_kinematics.hpp"

/// A positioner and an arm, and results of their measurements.
namespace truepose::positioner_cell {

using Matrix = Eigen::Matrix4d;

inline constexpr double kTracker_mm = 0.02;   // per axis
inline constexpr double kEccentric = 0.2e-3;  // of each gear, rad: 0.1 mm at half a metre

inline Joint table_joint(double a_mm, double alpha_deg, double d_mm, double most_deg) {
  return {.a_mm = a_mm,
          .alpha_rad = alpha_deg * kRadPerDeg,
          .d_mm = d_mm,
          .min = -most_deg * kRadPerDeg,
          .max = most_deg * kRadPerDeg,
          .speed = 1};
}

inline RobotModel turntable() { return {.name = "turntable", .joints = {table_joint(0, 0, 450, 185)}}; }
inline RobotModel tilt_and_turn() {
  return {.name = "tilt and turn", .joints = {table_joint(0, 90, 0, 90), table_joint(120, -90, 250, 185)}};
}

inline Matrix rigid(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& turn_rad) {
  Matrix X = plain::shifted(p_mm);
  if (turn_rad.norm() > 0)
    X.topLeftCorner<3, 3>() = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
  return X;
}

inline const MeasurementNoise kNoise{.tracker = {.range_mm = kTracker_mm, .transverse_mm = kTracker_mm}};

/// A true KR 210 and a true positioner, with kinematics of the test's own; their measurements, and the
/// results.
class PositionerCell {
 public:
  PositionerCell(RobotModel table, std::uint64_t seed)
      : random_(seed), nominal_(std::move(table)), drawn_arm_(example::kr210()) {
    arm_ = example::placed(example::with_paper_errors(drawn_arm_), random_);
    X_WB_ = arm_.base.isometry().matrix();
    // What link 1 errs by is the base's by convention: the arm cannot tell one from the other.
    const auto first = [](const Joint& j) -> Matrix {
      return plain::turned(1, j.beta_rad) * plain::turned(0, j.alpha_rad) * plain::shifted({j.a_mm, 0, 0});
    };
    const Joint &drawn = drawn_arm_.joints[0], &real = arm_.robot.joints[0];
    X_WB_told_ = X_WB_ * first(real) * plain::turned(2, real.theta_rad - drawn.theta_rad) *
                 plain::shifted({0, 0, real.d_mm - drawn.d_mm}) * first(drawn).inverse();

    X_given_ = plain::kuka_frame({1900, 350, -150}, {25, 0, 0});
    X_root_ = X_given_ * rigid(random_.uniform(2, 4) * normal(random_, 1).normalized(),
                               random_.uniform(2e-3, 4e-3) * normal(random_, 1).normalized());
    truth_ = nominal_;
    if (truth_.joint_count() == 2) {
      truth_.joints[1].a_mm += 0.3 * random_.normal();
      truth_.joints[1].alpha_rad += 3e-4 * random_.normal();
    }
    for (double& phase : phases_) phase = random_.uniform(0, 2 * std::numbers::pi);
    X_FU_ = plain::kuka_frame({random_.uniform(-150, 150), random_.uniform(-150, 150), 80},
                              {random_.uniform(-170, 170), 3, -2});
  }

  JointVector angles() { return example::random_joints(nominal_, random_); }
  Eigen::Vector3d on_table() {
    const double angle = random_.uniform(0, 2 * std::numbers::pi), radius = random_.uniform(150, 600);
    return {radius * std::cos(angle), radius * std::sin(angle), random_.uniform(20, 350)};
  }
  /// The table in the tracker's frame.
  Matrix table_at(const JointVector& q) const {
    JointVector turned = q;
    for (Eigen::Index i = 0; i < q.size(); ++i)
      turned[i] += eccentric_ * std::sin(q[i] + phases_[static_cast<std::size_t>(i)]);
    return X_WB_told_ * X_root_ * plain::flange(truth_, turned);
  }
  Eigen::Vector3d seen(const Eigen::Vector3d& p_W_mm) { return p_W_mm + normal(random_, kTracker_mm); }

  /// Reflectors anywhere on the table, read at so many angles.
  MeasurementData table_data(int reflectors, int poses) {
    std::vector<Eigen::Vector3d> p_F_mm;
    MeasurementData data;
    for (int k = 0; k < reflectors; ++k) {
      p_F_mm.push_back(on_table());
      data.smr_names.push_back(std::to_string(k + 1));
    }
    for (int i = 0; i < poses; ++i) {
      JointVector q = angles();
      // A turntable is turned in steps.
      if (q.size() == 1) q[0] = nominal_.joints[0].min * (1 - 2.0 * i / (poses - 1));
      for (int k = 0; k < reflectors; ++k)
        data.points.push_back(
            {.q = q,
             .p_WS_mm = seen(plain::moved(table_at(q), p_F_mm[static_cast<std::size_t>(k)])),
             .smr = k,
             .row = static_cast<int>(data.points.size()) + 1});
    }
    return data;
  }

  /// The arm in 60 poses of its own.
  MeasurementData arm_data() {
    MeasurementData data{.smr_names = {"1"}};
    for (const JointVector& q : random_poses(drawn_arm_, 60, random_))
      data.points.push_back({.q = q, .p_WS_mm = seen(tcp(q))});
    return data;
  }
  MeasuringCell calibrated_arm() {
    const auto calibration = calibrate(drawn_arm_, arm_data(), {.noise = kNoise});
    return {calibration->cell, calibration->covariance, kNoise};
  }
  /// The TCP is the reflector.
  Eigen::Vector3d tcp(const JointVector& q) const {
    return plain::moved(X_WB_ * plain::flange(arm_.robot, q), arm_.reflectors[0].p_FS_mm);
  }

  /// Reflectors at origin, x and xy of the workpiece, each at so many angles of the table.
  FrameReadings workpiece(int times) {
    FrameReadings data{.points = {{kOrigin, {}}, {kOnX, {}}, {kInXy, {}}}};
    const std::vector<Eigen::Vector3d> p_U_mm{{0, 0, 0}, {350, 0, 0}, {40, 300, 0}};
    for (int i = 0; i < times; ++i) {
      const JointVector q = angles();
      for (std::size_t k = 0; k < p_U_mm.size(); ++k)
        data.readings.push_back({.point = k,
                                 .q = q,
                                 .p_WS_mm = seen(plain::moved(table_at(q) * X_FU_, p_U_mm[k])),
                                 .row = 3 * i + static_cast<int>(k) + 1});
    }
    return data;
  }

  Random& random() { return random_; }
  RobotModel& nominal() { return nominal_; }
  RobotModel& truth() { return truth_; }
  const RobotModel& drawn_arm() const { return drawn_arm_; }
  const Matrix& X_given() const { return X_given_; }
  const Matrix& X_root() const { return X_root_; }
  const Matrix& X_FU() const { return X_FU_; }
  void make_eccentric(double rad) { eccentric_ = rad; }

  /// Of the roots that no reading tells from the true one, that which is nearest to the given one.
  Matrix controller_root() const {
    if (nominal_.joint_count() > 1) return X_root_;
    const auto likeness = [&](double rad) {
      return (X_given_.transpose() * X_root_ * plain::turned(2, rad)).topLeftCorner<3, 3>().trace();
    };
    double low = -0.1, high = 0.1;
    for (int i = 0; i < 100; ++i) {
      const double left = low + (high - low) / 3, right = high - (high - low) / 3;
      (likeness(left) < likeness(right) ? low : high) = likeness(left) < likeness(right) ? left : right;
    }
    const Eigen::Vector3d off = plain::moved(X_root_.inverse(), X_given_.topRightCorner<3, 1>());
    return X_root_ * plain::shifted({0, 0, off.z()}) * plain::turned(2, (low + high) / 2);
  }

 private:
  Random random_;
  RobotModel nominal_, truth_, drawn_arm_;
  CalibratedCell arm_;
  Matrix X_WB_, X_WB_told_, X_given_, X_root_, X_FU_;
  double eccentric_ = kEccentric;
  double phases_[2] = {0, 0};
};

struct Found {
  Calibration calibration;
  MeasuringCell table;
};

inline std::optional<Found> calibrated(const RobotModel& nominal, const MeasurementData& data) {
  auto calibration = calibrate(nominal, data, {.noise = kNoise, .non_geometric = true});
  if (!calibration) {
    ADD_FAILURE() << calibration.error().detail;
    return std::nullopt;
  }
  MeasuringCell table{calibration->cell, calibration->covariance, kNoise};
  return Found{*std::move(calibration), std::move(table)};
}

class Positioner : public testing::TestWithParam<int> {
 protected:
  RobotModel drawn() const { return GetParam() == 1 ? turntable() : tilt_and_turn(); }
};

}  // namespace truepose::positioner_cell
