#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>

#include "core/arm/forward.hpp"
#include "core/arm/robot_model.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose {

inline const RobotModel kNominal = published_arm();
inline const RobotModel kReal = with_published_errors(kNominal);
inline const Eigen::Vector3d kTcp_mm{120, -40, 300};

inline JointVector deg(std::initializer_list<double> q) {
  JointVector result(static_cast<Eigen::Index>(q.size()));
  std::ranges::copy(q, result.begin());
  return result * kRadPerDeg;
}

/// Joints away from the singularities of shoulder and elbow, |A5| at least `least_A5_deg`.
inline JointVector regular_joints(Random& random, double least_A5_deg) {
  const double A5 = random.uniform(least_A5_deg, 115) * (random.uniform(0, 1) < 0.5 ? -1 : 1);
  return deg({random.uniform(-180, 180), random.uniform(-90, -30), random.uniform(60, 110),
              random.uniform(-300, 300), A5, random.uniform(-300, 300)});
}

/// Arms that deviate by their geometry, by their joints too, and by a field.
inline RobotModel bending(RobotModel robot) {
  robot.deviation = {{.joint = 1, .basis = DeviationBasis::Weight, .order = 5, .coefficient = 4e-4},
                     {.joint = 2, .basis = DeviationBasis::Sine, .order = 2, .coefficient = 3e-4},
                     {.joint = 4, .basis = DeviationBasis::Cosine, .order = 1, .coefficient = 2e-4}};
  return robot;
}

class WavingField final : public ResidualField {
 public:
  Eigen::Isometry3d displaced(const JointVector& q, const Eigen::Isometry3d& X_BF) const noexcept override {
    Eigen::Isometry3d X = X_BF;
    X.translation() += 0.3 * Eigen::Vector3d(std::sin(q[0]), std::cos(q[1]), std::sin(2 * q[3]));
    X.linear() = Eigen::AngleAxisd(4e-4 * std::sin(q[2]), Eigen::Vector3d::UnitY()) * X.linear();
    return X;
  }
  Eigen::Matrix3d covariance(const JointVector&, const Eigen::Isometry3d&,
                             const Eigen::Vector3d&) const override {
    return Eigen::Matrix3d::Zero();
  }
};

inline RobotModel with_field(RobotModel robot) {
  robot.field = std::make_shared<WavingField>();
  return robot;
}

inline double mm_between(const RobotModel& robot, const JointVector& q, const Eigen::Vector3d& p_B_mm,
                         const Eigen::Vector3d& p_F_mm) {
  return (forward_kinematics(robot, q) * p_F_mm - p_B_mm).norm();
}

}  // namespace truepose
