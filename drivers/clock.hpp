#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstdint>
#include <functional>

namespace truepose::drivers {

using TimePoint = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

inline std::int64_t nanoseconds_of(TimePoint time) {
  return std::chrono::nanoseconds{time.time_since_epoch()}.count();
}
inline TimePoint time_of(std::int64_t nanoseconds) {
  return TimePoint{std::chrono::nanoseconds{nanoseconds}};
}

/// The time that drivers and campaign live in: the machine's steady clock, or virtual time in tests.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual TimePoint now() const = 0;
  /// Returns at `when`; throws boost::system::system_error(operation_aborted) when cancelled.
  virtual boost::asio::awaitable<void> sleep_until(TimePoint when) = 0;
};

/// UTC, which people may set.
using WallClock = std::function<std::chrono::system_clock::time_point()>;

/// The machine's steady clock.
class SteadyClock final : public Clock {
 public:
  TimePoint now() const override;
  boost::asio::awaitable<void> sleep_until(TimePoint when) override;
};

}  // namespace truepose::drivers
