#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstdint>
#include <optional>

#include "drivers/clock.hpp"

namespace truepose::sim {

/// What takes a simulated tracker time, one at once. A job whose number is not the current one was dropped.
class TrackerJobs {
 public:
  using Job = std::uint64_t;
  using Duration = drivers::Duration;

  /// @param speedup  so much less time everything takes
  TrackerJobs(drivers::Clock& clock, double speedup) : clock_{clock}, speedup_{speedup} {}

  bool busy() const { return job_.has_value(); }
  bool is_current(Job job) const { return job_ == job; }
  Job begin() {
    job_ = ++last_;
    return *job_;
  }
  void drop() { job_.reset(); }

  Duration scaled(Duration simulated) const {
    return std::chrono::duration_cast<Duration>(simulated / speedup_);
  }
  /// A job that is dropped meanwhile sleeps on, and then ends.
  /// @return whether the job continues
  boost::asio::awaitable<bool> wait(Job job, Duration simulated) {
    const drivers::TimePoint end = clock_.now() + scaled(simulated);
    co_await clock_.sleep_until(end);
    co_return job_ == job;
  }

 private:
  drivers::Clock& clock_;
  const double speedup_;
  std::optional<Job> job_;
  Job last_ = 0;
};

// How long a tracker takes.
inline constexpr std::chrono::seconds kInitializeTime{20};
inline constexpr std::chrono::seconds kDriveTime{1};
inline constexpr std::chrono::milliseconds kSearchTime{500};

}  // namespace truepose::sim
