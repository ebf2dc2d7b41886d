#include "tools/truepose/bridge/bridge_line.hpp"

#include <algorithm>
#include <utility>

#include "drivers/deadline.hpp"

namespace truepose::tools {

using drivers::before;

BridgeTask<void> BridgeLine::open(std::string host, std::uint16_t port) {
  close();
  const auto opened = co_await wire_.open(std::move(host), port);
  if (!opened) co_return std::unexpected(opened.error().detail);
  co_return std::expected<void, std::string>{};
}

void BridgeLine::close() noexcept {
  wire_.close();
  lines_ = control::LineSplitter{bridge::kMaxLine};
}

BridgeTask<void> BridgeLine::send(std::string bytes) {
  const auto sent = co_await wire_.send(std::move(bytes));
  if (!sent) co_return std::unexpected(sent.error().detail);
  co_return std::expected<void, std::string>{};
}

BridgeTask<bridge::FromBridge> BridgeLine::next(drivers::Duration patience) {
  const drivers::TimePoint deadline = wire_.clock().now() + patience;
  for (;;) {
    if (const auto line = lines_.next()) {
      auto message = bridge::decode_from_bridge(*line);
      if (!message)
        co_return std::unexpected("the line " + line->substr(0, 100) + " is no message: " + message.error());
      co_return *std::move(message);
    }
    if (lines_.overflowed()) co_return std::unexpected("a line is longer than 64 KiB");
    auto receiving = wire_.receive();
    const auto received = co_await before(wire_.clock(), deadline, std::move(receiving));
    if (!received) {
      const auto s = std::chrono::duration<double>(patience).count();
      co_return std::unexpected("nothing came within " + std::to_string(static_cast<int>(s)) + " s");
    }
    if (!*received) co_return std::unexpected(received->error().detail);
    lines_.push(**received);
  }
}

BridgeTask<bridge::Reply> BridgeLine::next_reply(drivers::Duration patience) {
  const drivers::TimePoint deadline = wire_.clock().now() + patience;
  for (;;) {
    auto message = co_await next(deadline - wire_.clock().now());
    if (!message) co_return std::unexpected(message.error());
    if (auto* reply = std::get_if<bridge::Reply>(&*message)) co_return std::move(*reply);
    events.push_back(std::get<bridge::Event>(*std::move(message)));
  }
}

BridgeTask<bridge::Reply> BridgeLine::reply_to(std::int64_t id, drivers::Duration patience) {
  auto reply = co_await next_reply(patience);
  if (!reply || reply->id == id) co_return reply;
  const std::string found = reply->id ? std::to_string(*reply->id) : "none";
  co_return std::unexpected("the answer to request " + std::to_string(id) + " has the id " + found);
}

bool BridgeLine::has_seen(bridge::EventKind kind) const {
  return std::ranges::any_of(events, [kind](const bridge::Event& event) { return event.kind() == kind; });
}

}  // namespace truepose::tools
