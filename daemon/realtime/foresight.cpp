#include "daemon/realtime/foresight.hpp"

namespace truepose::daemon {

TargetCompensation::Result Foresight::at_joints(const TargetCompensation& compensation,
                                                const JointVector& commanded,
                                                const Eigen::Vector3d& p_F_mm) noexcept {
  const auto is_near = [this](const TargetCompensation::Result& result) {
    return result && (result->q - ahead_->q).cwiseAbs().maxCoeff() <= kNear_rad;
  };
  auto result =
      ahead_ ? compensation.at_joints(commanded, p_F_mm, *ahead_) : compensation.at_joints(commanded, p_F_mm);
  if (ahead_ && !is_near(result)) result = compensation.at_joints(commanded, p_F_mm);
  now_ = result ? std::optional{result->q} : std::nullopt;
  return result;
}

void Foresight::look_ahead(const TargetCompensation& compensation) noexcept {
  if (!now_) return;
  ahead_ = compensation.beyond_geometry(before_ ? JointVector(2 * *now_ - *before_) : *now_);
  before_ = now_;
  now_.reset();
}

}  // namespace truepose::daemon
