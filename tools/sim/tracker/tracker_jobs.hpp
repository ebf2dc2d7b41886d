#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <cstdint>
#include <optional>

namespace truepose::sim {

/// What takes a simulated tracker time, one at once. A job whose number is no longer the current one was
/// dropped.
class TrackerJobs {
 public:
  using Job = std::uint64_t;
  using Duration = std::chrono::steady_clock::duration;

  /// @param speedup  so much less time everything takes
  TrackerJobs(const boost::asio::any_io_executor& executor, double speedup)
      : timer_{executor}, speedup_{speedup} {}

  bool busy() const { return job_.has_value(); }
  bool is_current(Job job) const { return job_ == job; }
  Job begin() {
    job_ = ++last_;
    return *job_;
  }
  void drop() {
    job_.reset();
    timer_.cancel();
  }

  Duration scaled(Duration simulated) const {
    return std::chrono::duration_cast<Duration>(simulated / speedup_);
  }
  /// @return whether the job continues
  boost::asio::awaitable<bool> wait(Job job, Duration simulated) {
    timer_.expires_after(scaled(simulated));
    co_await timer_.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
    co_return job_ == job;
  }

 private:
  boost::asio::steady_timer timer_;
  const double speedup_;
  std::optional<Job> job_;
  Job last_ = 0;
};

// How long a tracker takes.
inline constexpr std::chrono::seconds kInitializeTime{20};
inline constexpr std::chrono::seconds kDriveTime{1};
inline constexpr std::chrono::milliseconds kSearchTime{500};

}  // namespace truepose::sim
