#pragma once

#include <Eigen/LU>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/frames/frame_readings.hpp"
#include "core/math/random.hpp"
#include "tests/core/plain_kinematics.hpp"

namespace truepose::test {

/// Somebody who jogs an arm until a point of its tool touches another, by kinematics of the test's own.
class JoggingHand {
 public:
  /// @param truth     the arm as it really is
  /// @param sigma_mm  per axis, to which hand and arm come to the point
  JoggingHand(RobotModel truth, double sigma_mm, std::uint64_t seed)
      : truth_{std::move(truth)}, sigma_mm_{sigma_mm}, random_{seed} {}

  /// Joints at which the point of the flange truly stands there, turned otherwise each time.
  JointVector touching(const Eigen::Vector3d& p_B_mm, const Eigen::Vector3d& p_F_mm) {
    const Eigen::Vector3d there_mm = p_B_mm + about();
    JointVector q = posture();
    for (int step = 0; step < 50; ++step) {
      const Eigen::Matrix<double, 3, 6> J = jacobian(q, p_F_mm);
      q += J.transpose() * (J * J.transpose()).inverse() * (there_mm - at(q, p_F_mm));
    }
    return q;
  }
  /// What a tracker that stands there sees of it in so many postures.
  FrameReadings tool_readings(int count, const Eigen::Isometry3d& X_WB, const Eigen::Vector3d& p_F_mm) {
    FrameReadings data{.points = {{kOrigin, std::nullopt}}, .readings = {}};
    for (int i = 1; i <= count; ++i) {
      const JointVector q = posture();
      data.readings.push_back({.point = 0, .q = q, .p_WS_mm = X_WB * (at(q, p_F_mm) + about()), .row = i});
    }
    return data;
  }

 private:
  Eigen::Vector3d about() {
    const double x = random_.normal(), y = random_.normal(), z = random_.normal();
    return sigma_mm_ * Eigen::Vector3d(x, y, z);
  }
  JointVector posture() {
    const auto turned = [&](double rad, double by) { return rad + random_.uniform(-by, by); };
    JointVector q(6);
    q << turned(0.2, 0.15), turned(-1.1, 0.1), turned(1.7, 0.1), turned(0.4, 0.6), turned(0.9, 0.3),
        turned(0.2, 1);
    return q;
  }
  Eigen::Vector3d at(const JointVector& q, const Eigen::Vector3d& p_F_mm) const {
    return plain::moved(plain::flange(truth_, q), p_F_mm);
  }
  Eigen::Matrix<double, 3, 6> jacobian(const JointVector& q, const Eigen::Vector3d& p_F_mm) const {
    constexpr double kStep_rad = 1e-6;
    Eigen::Matrix<double, 3, 6> J;
    for (Eigen::Index i = 0; i < 6; ++i) {
      const JointVector turn = kStep_rad * JointVector::Unit(6, i);
      J.col(i) = (at(q + turn, p_F_mm) - at(q - turn, p_F_mm)) / (2 * kStep_rad);
    }
    return J;
  }

  RobotModel truth_;
  double sigma_mm_;
  truepose::Random random_;
};

}  // namespace truepose::test
