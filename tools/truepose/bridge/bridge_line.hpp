#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <expected>
#include <string>
#include <vector>

#include "drivers/tracker_wire.hpp"
#include "proto/bridge/messages.hpp"
#include "proto/control/line_splitter.hpp"

namespace truepose::tools {

template <class T>
using BridgeTask = boost::asio::awaitable<std::expected<T, std::string>>;

/// In which a bridge answers what it only has to look up.
inline constexpr std::chrono::seconds kBridgeLookUp{3};

/// A connection to a bridge on which anything can be sent. Every error is one phrase that says what the
/// bridge did.
class BridgeLine {
 public:
  BridgeLine(std::unique_ptr<net::Stream> stream, drivers::Clock& clock)
      : wire_{std::move(stream), clock, drivers::kNullTap} {}

  BridgeTask<void> open(std::string host, std::uint16_t port);
  bool is_open() const { return wire_.is_open(); }
  void close() noexcept;

  /// Bytes as they are.
  BridgeTask<void> send(std::string bytes);
  /// @return its id
  template <class Request>
  BridgeTask<std::int64_t> send_request(Request request) {
    const std::int64_t id = ++last_id_;
    std::string line = bridge::encode(id, request) + "\n";
    const auto sent = co_await send(std::move(line));
    if (!sent) co_return std::unexpected(sent.error());
    co_return id;
  }
  std::int64_t new_id() { return ++last_id_; }

  /// The next answer or refusal; events before it are kept in `events`.
  BridgeTask<bridge::Reply> next_reply(drivers::Duration patience);
  /// The reply to this request; another one that comes instead is an error.
  BridgeTask<bridge::Reply> reply_to(std::int64_t id, drivers::Duration patience);

  /// The answer; a refusal is an error.
  template <class Request>
  BridgeTask<typename Request::Answer> ask(Request request, drivers::Duration patience) {
    const auto id = co_await send_request(std::move(request));
    if (!id) co_return std::unexpected(id.error());
    const auto reply = co_await reply_to(*id, patience);
    if (!reply) co_return std::unexpected(reply.error());
    co_return answer_in<Request>(*reply);
  }
  template <class Request>
  static std::expected<typename Request::Answer, std::string> answer_in(const bridge::Reply& reply) {
    const std::string name{Request::kName};
    if (!reply.outcome)
      return std::unexpected(name + " was refused: " + reply.outcome.error().text + " (" +
                             reply.outcome.error().code + ")");
    auto answer = bridge::answer_of<Request>(*reply.outcome);
    if (!answer) return std::unexpected("the answer to " + name + ": " + answer.error());
    return *std::move(answer);
  }

  /// Whether such an event has come since they were cleared.
  bool has_seen(bridge::EventKind kind) const;
  std::vector<bridge::Event> events;

 private:
  BridgeTask<bridge::FromBridge> next(drivers::Duration patience);

  drivers::TrackerWire wire_;
  control::LineSplitter lines_{bridge::kMaxLine};
  std::int64_t last_id_ = 0;
};

}  // namespace truepose::tools
