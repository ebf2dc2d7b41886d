#include "daemon/cell/store_watch.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::RpcError;

void StoreWatch::failed(const StoreError& error) {
  const FaultText text{"the store cannot be written to, and nothing new is begun: " + error.detail};
  runner_.faults().stand(true, {FaultCode::Store, sentence(text, "acknowledge")});
}

RpcError StoreWatch::refusal() const {
  RpcError refused =
      runner_.wrong_state(runner_.faults().text(FaultCode::Store) + " (cell.acknowledge)", runner_.allowed());
  refused.code = control::ErrorCode::Store;
  return refused;
}

asio::awaitable<StoreResult<void>> StoreWatch::try_again() {
  auto job = [this] { return parts_.store.try_again(); };
  co_return co_await parts_.store_thread.ask(job);
}

asio::awaitable<std::optional<RpcError>> StoreWatch::try_it() {
  auto usable = co_await try_again();
  if (usable) co_return std::nullopt;
  failed(usable.error());
  co_return refusal();
}

asio::awaitable<std::optional<RpcError>> StoreWatch::acknowledge() {
  auto usable = co_await try_again();
  if (!usable) {
    RpcError refused = runner_.wrong_state("the store still cannot be written to: " + usable.error().detail,
                                           runner_.allowed());
    refused.code = control::ErrorCode::Store;
    co_return refused;
  }
  runner_.faults().end(FaultCode::Store);
  co_await pay();
  if (when_usable_) co_await when_usable_();
  co_return std::nullopt;
}

asio::awaitable<void> StoreWatch::keep(std::string about, std::function<StoreResult<void>()> write) {
  pending_[about] = std::make_shared<const Write>(std::move(write));
  co_await pay();
}

asio::awaitable<void> StoreWatch::pay() {
  while (!pending_.empty()) {
    const auto [about, write] = *pending_.begin();
    auto job = [pending = write] { return (*pending)(); };
    auto written = co_await parts_.store_thread.ask(job);
    if (!written) {
      failed(written.error());
      co_return;
    }
    const auto still = pending_.find(about);
    if (still != pending_.end() && still->second == write) pending_.erase(still);
  }
}

asio::awaitable<void> StoreWatch::watch() {
  constexpr std::chrono::seconds kTry{1};
  for (;;) {
    const TimePoint next = parts_.clock.now() + kTry;
    co_await parts_.clock.sleep_until(next);
    co_await pay();
    co_await look();
  }
}

asio::awaitable<void> StoreWatch::look() {
  auto job = [this] { return parts_.store.in_place(); };
  auto there = co_await parts_.store_thread.ask(job);
  if (!there) failed(there.error());
}

}  // namespace truepose::daemon
