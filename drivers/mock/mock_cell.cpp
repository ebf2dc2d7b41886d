#include "drivers/mock/mock_cell.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/kinematics/forward.hpp"
#include "core/planning/pose_sampler.hpp"

namespace truepose::drivers {

MockCell::MockCell(MockCellOptions options, Clock& clock)
    : options_{std::move(options)},
      clock_{clock},
      random_{options_.seed},
      from_{options_.q_start},
      to_{options_.q_start},
      start_{clock.now()},
      end_{clock.now()} {}

void MockCell::start_motion(const JointVector& q, double speed_percent) {
  from_ = this->q();
  to_ = q;
  start_ = clock_.now();
  const double seconds = travel_time_s(options_.nominal, from_, to_) * 100 / speed_percent;
  end_ = start_ + std::chrono::duration_cast<Duration>(std::chrono::duration<double>{seconds});
  stop_error_mm_ = gauss3(options_.repeatability_mm);
}

void MockCell::stop_motion() {
  to_ = q();
  from_ = to_;
  end_ = std::min(end_, clock_.now());
}

JointVector MockCell::q() const {
  if (!moving()) return to_;
  const double part = std::chrono::duration<double>(clock_.now() - start_) / std::chrono::duration<double>(end_ - start_);
  return from_ + part * (to_ - from_);
}

Eigen::Vector3d MockCell::p_WS_mm() const {
  return options_.X_WB * forward_kinematics(options_.truth, q()) * options_.p_FS_mm + stop_error_mm_;
}

bool MockCell::visible() const {
  const Eigen::Isometry3d X_WF = options_.X_WB * forward_kinematics(options_.truth, q());
  const Eigen::Vector3d p_WS_mm = X_WF * options_.p_FS_mm;
  const Eigen::Vector3d facing_W = X_WF.linear() * options_.facing_F.normalized();
  return facing_W.dot(-p_WS_mm.normalized()) >= std::cos(options_.acceptance_rad);
}

Eigen::Vector3d MockCell::reading_mm() { return p_WS_mm() + gauss3(options_.noise_mm); }

double MockCell::gauss() {
  const double radius = std::sqrt(-2 * std::log(1 - random_.uniform()));
  return radius * std::cos(2 * std::numbers::pi * random_.uniform());
}

Eigen::Vector3d MockCell::gauss3(double sigma_mm) {
  const double x = gauss();
  const double y = gauss();
  const double z = gauss();
  return sigma_mm * Eigen::Vector3d{x, y, z};
}

}  // namespace truepose::drivers
