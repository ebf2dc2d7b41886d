#include "tools/sim/alarms.hpp"

#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/dispatch.hpp>
#include <exception>
#include <utility>

#include "drivers/net/spawn.hpp"

namespace truepose::sim {

namespace asio = boost::asio;

struct Alarms::Alarm {
  std::function<void()> ring;  ///< empty: cancelled
  asio::cancellation_signal wake{};
};

Alarms::Alarms(asio::any_io_executor executor, drivers::Clock& clock)
    : executor_{std::move(executor)}, clock_{clock} {}

void Alarms::at(drivers::TimePoint when, std::function<void()> ring) {
  const auto alarm = std::make_shared<Alarm>(std::move(ring));
  pending_.insert(alarm);
  const auto slept = [this, alarm](std::exception_ptr) {
    if (!alarm->ring) return;
    pending_.erase(alarm);  // first: what it calls may clear all
    alarm->ring();
  };
  net::spawn(executor_, clock_.sleep_until(when), slept, alarm->wake.slot());
}

void Alarms::clear() {
  for (const auto& alarm : std::exchange(pending_, {})) {
    alarm->ring = nullptr;
    // While the loop stands still this waits in its queue, where the sleep may end before it.
    asio::dispatch(executor_, [alarm] { alarm->wake.emit(asio::cancellation_type::terminal); });
  }
}

}  // namespace truepose::sim
