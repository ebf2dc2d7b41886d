#include "daemon/campaign/nest_watch.hpp"

#include <string>

#include "daemon/campaign/corrected_points.hpp"

namespace truepose::daemon {

NestWatch::NestWatch(MeasuringSession& session)
    : session_{session}, seen_mm_{session.config().tracker.nests_mm} {}

CampaignOutcome<void> NestWatch::after_pose() {
  if (++poses_since_ < session_.config().campaign.nests_every) co_return Done{};
  co_return co_await measure();
}

CampaignOutcome<void> NestWatch::measure() {
  poses_since_ = 0;
  if (seen_mm_.empty()) co_return Done{};
  const config::TrackerConfig& tracker = session_.config().tracker;
  const double search_mm = begun_ ? tracker.search_radius_mm : tracker.first_search_radius_mm;
  const int number = session_.plan().next_number();
  for (std::size_t nest = 0; nest < seen_mm_.size(); ++nest) {
    const std::string name = kNestName + std::to_string(nest + 1);
    const FixedReflector reflector{number, name};
    auto point = co_await session_.measure_fixed(reflector, seen_mm_[nest], search_mm);
    if (!point) co_return std::unexpected(point.error());
    if (*point) seen_mm_[nest] = *(*point)->p_WS_mm;
  }
  begun_ = true;
  co_return Done{};
}

}  // namespace truepose::daemon
