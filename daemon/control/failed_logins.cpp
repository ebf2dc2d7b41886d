#include "daemon/control/failed_logins.hpp"

#include <algorithm>

namespace truepose::daemon {

void FailedLogins::count(const std::string& peer, drivers::TimePoint now) {
  forget_old(now);
  if (times_.size() == kMostPeers && !times_.contains(peer)) {
    const auto failed_last = [](const auto& each) { return each.second.back(); };
    times_.erase(std::ranges::min_element(times_, {}, failed_last));
  }
  times_[peer].push_back(now);
}

std::size_t FailedLogins::of(const std::string& peer, drivers::TimePoint now) {
  forget_old(now);
  const auto found = times_.find(peer);
  return found == times_.end() ? 0 : found->second.size();
}

void FailedLogins::forget_old(drivers::TimePoint now) {
  for (auto& [peer, times] : times_)
    while (!times.empty() && now - times.front() >= window_) times.pop_front();
  std::erase_if(times_, [](const auto& each) { return each.second.empty(); });
}

}  // namespace truepose::daemon
