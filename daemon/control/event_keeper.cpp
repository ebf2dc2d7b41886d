#include "daemon/control/event_keeper.hpp"

#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using namespace std::chrono_literals;

namespace {

constexpr drivers::Duration kEvery = 1s;
constexpr drivers::Duration kPruneEvery = 1h;
constexpr std::size_t kAtATime = 256;

}  // namespace

asio::awaitable<void> EventKeeper::run() {
  for (;;) {
    const drivers::TimePoint next = parts_.clock.now() + kEvery;
    co_await parts_.clock.sleep_until(next);
    co_await write();
    if (parts_.clock.now() < prune_at_) continue;
    prune_at_ = parts_.clock.now() + kPruneEvery;
    co_await prune();
  }
}

asio::awaitable<void> EventKeeper::write() {
  for (EventBatch batch = parts_.events.unwritten(kAtATime); !batch.events.empty();
       batch = parts_.events.unwritten(kAtATime)) {
    auto job = [archive = parts_.events.archive(), batch] { return archive->keep_events(batch); };
    auto kept = co_await parts_.worker.ask(job);
    if (!kept) {
      parts_.failed(kept.error());
      co_return;
    }
    parts_.events.written(batch);
  }
}

asio::awaitable<void> EventKeeper::prune() {
  const std::string before = control::rfc3339(parts_.wall_clock() - kKept);
  for (;;) {
    auto job = [archive = parts_.events.archive(), before] { return archive->prune_events(before); };
    auto more = co_await parts_.worker.ask(job);
    if (!more) parts_.failed(more.error());
    if (!more || !*more) co_return;
  }
}

}  // namespace truepose::daemon
