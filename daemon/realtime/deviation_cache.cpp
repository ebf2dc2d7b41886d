#include "daemon/realtime/deviation_cache.hpp"

namespace truepose::daemon {

TargetCompensation::Result DeviationCache::at_joints_within(int steps, const TargetCompensation& compensation,
                                                            const JointVector& commanded,
                                                            const Eigen::Vector3d& p_F_mm,
                                                            JointVector& correction) noexcept {
  const auto search = [&](JointVector& from, const NonGeometricError* beyond) {
    return compensation.at_joints_within(steps, commanded, p_F_mm, from, beyond);
  };
  const auto is_near = [this](const TargetCompensation::Result& result) {
    return result && (result->q - ahead_->q).cwiseAbs().maxCoeff() <= kNear_rad;
  };
  JointVector ahead_correction = correction;
  auto result = ahead_ ? search(ahead_correction, &*ahead_) : search(correction, nullptr);
  if (ahead_ && is_near(result)) {
    correction = ahead_correction;
  } else if (ahead_) {
    result = search(correction, nullptr);
  }
  now_ = result ? std::optional{result->q} : std::nullopt;
  return result;
}

void DeviationCache::look_ahead(const TargetCompensation& compensation) noexcept {
  if (!now_) return;
  ahead_ = compensation.non_geometric_error(before_ ? JointVector(2 * *now_ - *before_) : *now_);
  before_ = now_;
  now_.reset();
}

}  // namespace truepose::daemon
