#include "daemon/control/wrong_guesses.hpp"

#include <algorithm>

namespace truepose::daemon {

void WrongGuesses::count(const std::string& peer, drivers::TimePoint now) {
  forget_old(now);
  if (guesses_.size() == kMostPeers && !guesses_.contains(peer)) {
    const auto failed_last = [](const auto& each) { return each.second.back(); };
    guesses_.erase(std::ranges::min_element(guesses_, {}, failed_last));
  }
  guesses_[peer].push_back(now);
}

std::size_t WrongGuesses::of(const std::string& peer, drivers::TimePoint now) {
  forget_old(now);
  const auto found = guesses_.find(peer);
  return found == guesses_.end() ? 0 : found->second.size();
}

void WrongGuesses::forget_old(drivers::TimePoint now) {
  for (auto& [peer, times] : guesses_)
    while (!times.empty() && now - times.front() >= window_) times.pop_front();
  std::erase_if(guesses_, [](const auto& each) { return each.second.empty(); });
}

}  // namespace truepose::daemon
