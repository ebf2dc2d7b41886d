#include "core/simulation/true_arm.hpp"

#include <cmath>
#include <utility>

#include "core/kinematics/angles.hpp"
#include "core/kinematics/forward.hpp"

namespace truepose {
namespace {

// By so much (rad, mm) the joints of two poses may differ that were meant to be the same.
constexpr double kRounding = 1e-9;

}  // namespace

TrueArm::TrueArm(TrueArmSetup setup, std::uint64_t seed) : setup_{std::move(setup)}, random_{seed} {
  setup_.facing_F.normalize();
  stop_anew();
}

void TrueArm::stop_anew() {
  for (double& axis_mm : deviation_mm_) axis_mm = setup_.repeatability_mm * random_.normal();
}

void TrueArm::move(const JointVector& from, const JointVector& to) {
  directions_.resize(setup_.robot.joints.size(), 0);
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (std::abs(to[k] - from[k]) > kRounding) directions_[i] = to[k] > from[k] ? 1 : -1;
  }
  stands_at_ = to;
  stop_anew();
}

void TrueArm::move_to(const JointVector& q) { move(directions_.empty() ? q : stands_at_, q); }

Eigen::Isometry3d TrueArm::X_BF(const JointVector& q) const {
  return forward_kinematics(setup_.robot,
                            q + joint_displacement(setup_.robot, setup_.non_geometric, q, directions_));
}

Eigen::Vector3d TrueArm::p_WS_mm(const JointVector& q) const {
  return setup_.X_WB * (X_BF(q) * setup_.p_FS_mm + deviation_mm_);
}

bool TrueArm::visible(const JointVector& q) const {
  const Eigen::Isometry3d X_BF_true = X_BF(q);
  const Eigen::Vector3d p_BS_mm = X_BF_true * setup_.p_FS_mm;
  const Eigen::Vector3d to_tracker_B = (inverse_of(setup_.X_WB).translation() - p_BS_mm).normalized();
  const Eigen::Vector3d facing_B = X_BF_true.linear() * setup_.facing_F;
  return p_BS_mm.z() > 0 && facing_B.dot(to_tracker_B) >= std::cos(setup_.acceptance_rad);
}

}  // namespace truepose
