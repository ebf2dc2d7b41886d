#pragma once

#include <boost/asio/awaitable.hpp>
#include <string>

#include "daemon/campaign/progress_counter.hpp"
#include "daemon/threads/signal.hpp"

namespace truepose::daemon {

/// The pauses of a campaign, which an operator ends. They take effect before the next pose.
class CampaignPause {
 public:
  /// @param observer, progress  outlive it
  CampaignPause(CampaignObserver& observer, const ProgressCounter& progress)
      : observer_{observer}, progress_{progress} {}

  void begin() {
    paused_ = true;
    progress_.report();
  }
  void end() {
    paused_ = false;
    resumed_.notify();
    progress_.report();
  }
  /// Returns at once where there is none.
  boost::asio::awaitable<void> wait() {
    while (paused_) co_await resumed_.wait();
  }
  /// Begins one, for which the sentence says why and what is to be done, and waits for its end.
  boost::asio::awaitable<void> wait_for_operator(std::string sentence) {
    paused_ = true;
    observer_.on_paused(sentence);
    progress_.report();
    co_await wait();
  }

 private:
  CampaignObserver& observer_;
  const ProgressCounter& progress_;
  bool paused_ = false;
  Signal resumed_;
};

}  // namespace truepose::daemon
