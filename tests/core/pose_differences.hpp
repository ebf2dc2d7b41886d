#pragma once

#include <gtest/gtest.h>

#include "core/arm/forward.hpp"
#include "core/fit/measurement_model.hpp"

namespace truepose {

/// Whether the Jacobian at q is what central differences of the flange's pose come to.
inline void expect_differences(const RobotModel& arm, const JointVector& q, const PoseAndJacobian& at) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    constexpr double kStep = 1e-5;
    JointVector ahead = q, behind = q;
    ahead[i] += kStep;
    behind[i] -= kStep;
    const Eigen::Isometry3d A = forward_kinematics(arm, ahead), B = forward_kinematics(arm, behind);
    const Eigen::Vector3d v = (A.translation() - B.translation()) / (2 * kStep);
    const Eigen::Matrix3d W = (A.linear() - B.linear()) / (2 * kStep) * at.X_BF.linear().transpose();
    EXPECT_LT((at.J.col(i).head<3>() - v).norm(), 1e-5 * (1 + v.norm()));
    EXPECT_LT((at.J.col(i).tail<3>() - Eigen::Vector3d(W(2, 1), W(0, 2), W(1, 0))).norm(), 1e-8);
  }
}

/// Whether the derivatives of a predicted point to every parameter are what its central differences come to.
inline void expect_differences(const CalibratedCell& cell, const JointVector& q, int smr,
                               const PointJacobian& J) {
  constexpr double kStep = 1e-5;
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(J.cols(), k);
    const Eigen::Vector3d slope =
        (moved(cell, step).predict(q, smr) - moved(cell, -step).predict(q, smr)) / (2 * kStep);
    EXPECT_LT((J.col(k) - slope).norm(), 1e-6 * (1 + slope.norm()))
        << parameter_names(cell)[static_cast<std::size_t>(k)];
  }
}

}  // namespace truepose
