#include "tools/sim/alarms.hpp"

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/dispatch.hpp>
#include <boost/system/system_error.hpp>
#include <cstdint>
#include <exception>
#include <map>
#include <utility>
#include <vector>

#include "drivers/net/spawn.hpp"

namespace truepose::sim {

namespace asio = boost::asio;

namespace {

struct Sleep {
  drivers::TimePoint until;
  asio::cancellation_signal end{};
  bool is_over = false;
};

}  // namespace

struct Alarms::Pending {
  asio::any_io_executor executor;
  drivers::Clock& clock;
  std::map<std::pair<drivers::TimePoint, std::uint64_t>, std::function<void()>> rings{};
  std::uint64_t count = 0;
  std::vector<std::shared_ptr<Sleep>> asleep{};
  bool is_ringing = false;

  /// Whether a coroutine wakes in time.
  bool is_awaited(drivers::TimePoint when) const {
    return std::ranges::any_of(asleep, [when](const auto& sleep) { return sleep->until <= when; });
  }

  /// What it calls may set others, and clear all.
  void ring_due() {
    is_ringing = true;
    while (!rings.empty() && rings.begin()->first.first <= clock.now()) {
      const auto ring = rings.extract(rings.begin());
      ring.mapped()();
    }
    is_ringing = false;
  }

  /// One coroutine rings them all. Another one comes where an alarm is due before that wakes.
  static asio::awaitable<void> run(std::shared_ptr<Pending> its, std::shared_ptr<Sleep> sleep) {
    for (;;) {
      try {
        co_await its->clock.sleep_until(sleep->until);
      } catch (const boost::system::system_error&) {
        co_return;  // cleared
      }
      if (sleep->is_over) co_return;
      std::erase(its->asleep, sleep);
      its->ring_due();
      if (its->rings.empty()) co_return;
      sleep->until = its->rings.begin()->first.first;
      if (its->is_awaited(sleep->until)) co_return;
      its->asleep.push_back(sleep);
    }
  }
};

Alarms::Alarms(asio::any_io_executor executor, drivers::Clock& clock)
    : pending_{std::make_shared<Pending>(std::move(executor), clock)} {}

void Alarms::at(drivers::TimePoint when, std::function<void()> ring) {
  pending_->rings.emplace(std::pair{when, pending_->count++}, std::move(ring));
  if (pending_->is_ringing || pending_->is_awaited(when)) return;
  const auto sleep = std::make_shared<Sleep>(when);
  pending_->asleep.push_back(sleep);
  const auto ended = [sleep](std::exception_ptr failed) { net::rethrow(std::move(failed)); };
  net::spawn(pending_->executor, Pending::run(pending_, sleep), ended, sleep->end.slot());
}

void Alarms::clear() {
  pending_->rings.clear();
  for (const auto& sleep : std::exchange(pending_->asleep, {})) {
    sleep->is_over = true;
    // While the loop stands still this waits in its queue, where the sleep may end before it.
    asio::dispatch(pending_->executor, [sleep] { sleep->end.emit(asio::cancellation_type::terminal); });
  }
}

}  // namespace truepose::sim
