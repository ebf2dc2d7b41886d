#include "core/compensate/tracker_loop.hpp"

#include <algorithm>
#include <array>

#include "core/arm/forward.hpp"
#include "core/data/error_bounds.hpp"

namespace truepose {
namespace {

// Rounds: noise alone makes two of them no better than a first one that happened to be good.
constexpr int kNoBetter = 3;

}  // namespace

std::string_view name_of(TrackerLoopEnd end) {
  constexpr std::array<std::string_view, 4> kNames{"reached", "does_not_fall", "rounds_used", "out_of_reach"};
  return kNames[static_cast<std::size_t>(end)];
}

TrackerLoop::TrackerLoop(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm, const JointVector& q,
                         const TrackerLoopOptions& options)
    : arm_{cell.robot, cell.robot},
      R_BW_{cell.base.isometry().linear().transpose()},
      p_FS_mm_{cell.reflectors.front().p_FS_mm},
      wanted_W_mm_{p_WS_mm},
      aim_B_mm_{forward_kinematics(cell.robot, q) * p_FS_mm_},
      options_{options},
      q_{q},
      q_first_{q},
      q_best_{q} {}

void TrackerLoop::add(const Eigen::Vector3d& p_WS_mm) {
  const Eigen::Vector3d missing_W = wanted_W_mm_ - p_WS_mm;
  errors_mm_.push_back(missing_W.norm());
  if (std::ranges::min_element(errors_mm_) == errors_mm_.end() - 1) q_best_ = q_;
  correct(missing_W);
  if (!end_) judge();
}

void TrackerLoop::correct(const Eigen::Vector3d& missing_W) {
  const Eigen::Vector3d aim_B_mm = aim_B_mm_ + R_BW_ * missing_W / static_cast<double>(errors_mm_.size());
  const auto next = arm_.at_position(aim_B_mm, q_first_, p_FS_mm_);
  // Written so that a NaN ends the loop as well.
  if (!(errors_mm_.back() <= kMaxArmError_mm) || !next) {
    end_ = TrackerLoopEnd::OutOfReach;
    return;
  }
  aim_B_mm_ = aim_B_mm;
  q_ = next->q;
}

void TrackerLoop::judge() {
  const bool no_better = errors_mm_.size() > 1 && averaged_error_mm() >= errors_mm_.front();
  no_better_ = no_better ? no_better_ + 1 : 0;
  if (averaged_error_mm() <= options_.tolerance_mm) {
    end_ = TrackerLoopEnd::Reached;
  } else if (no_better_ == kNoBetter) {
    end_ = TrackerLoopEnd::DoesNotFall;
    q_ = q_best_;  // the mean of readings that drift apart is no estimate
  } else if (static_cast<int>(errors_mm_.size()) >= options_.rounds) {
    end_ = TrackerLoopEnd::RoundsUsed;
  }
}

double TrackerLoop::averaged_error_mm() const {
  return errors_mm_.back() / static_cast<double>(errors_mm_.size());
}

}  // namespace truepose
