#include "daemon/cell/store_watch.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::RpcError;

void StoreWatch::failed(const StoreError& error) {
  runner_.faults().stand(true, {kStoreFault, "error",
                                "the store cannot be written to, and nothing new is begun: " + error.detail});
}

std::optional<RpcError> StoreWatch::refusal() const {
  if (!failing()) return std::nullopt;
  return runner_.wrong_state(runner_.faults().text(kStoreFault) + "; allowed: cell.acknowledge",
                             {"cell.acknowledge"});
}

asio::awaitable<std::optional<RpcError>> StoreWatch::acknowledge() {
  auto job = [this] { return parts_.store.try_again(); };
  auto usable = co_await parts_.store_thread.ask(job);
  if (!usable)
    co_return runner_.wrong_state("the store still cannot be written to: " + usable.error().detail,
                                  {"cell.acknowledge"});
  runner_.faults().end(kStoreFault);
  if (when_usable_) co_await when_usable_();
  co_return std::nullopt;
}

}  // namespace truepose::daemon
