#include "daemon/realtime/approach_watch.hpp"

#include <algorithm>

namespace truepose::daemon {

void ApproachWatch::restart() noexcept {
  directions_.fill(0);
  begun_ = false;
}

bool ApproachWatch::take(const JointVector& commanded) noexcept {
  const auto before = directions_;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const double q = commanded[static_cast<Eigen::Index>(i)];
    Range& range = ranges_[i];
    if (!begun_) range = {q, q};
    range = {std::min(range.min, q), std::max(range.max, q)};
    const bool up = q - range.min > kShown_rad, down = range.max - q > kShown_rad;
    if (!up && !down) continue;
    directions_[i] = up ? 1 : -1;  // the range is never wider than kShown_rad
    range = {q, q};
  }
  begun_ = true;
  return directions_ != before;
}

}  // namespace truepose::daemon
