#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/tracker_wire.hpp"
#include "proto/bridge/messages.hpp"
#include "proto/control/line_splitter.hpp"

namespace truepose::drivers {

/// The fault that a bridge's refusal stands for, with its code and text.
TrackerError refusal(std::string_view what, const bridge::Refusal& refusal);

/// Requests to a bridge and their answers, over one TCP connection. After Disconnected, Timeout and Protocol
/// it is closed.
class BridgeConnection {
 public:
  /// @param clock    outlives it
  /// @param observe  sees every event
  BridgeConnection(std::unique_ptr<net::Stream> stream, Clock& clock,
                   std::function<void(const bridge::Event&)> observe, WireTap tap);

  TrackerTask<void> open(std::string host, std::uint16_t port);
  bool is_open() const { return wire_.is_open(); }
  void close() noexcept;

  /// Why an event is the end of what was asked for; nothing: it is not.
  using Ends = std::function<std::optional<TrackerError>(const bridge::Event&)>;

  /// Sends a request and waits for its answer, a refusal turned into an error. The answer to one that was
  /// left (cancelled, ended by an event) is passed over when it comes. While it waits it asks again and again
  /// whether the bridge lives.
  ///
  /// @param what      begins a refusal's sentence: "the tracker refuses its air"
  /// @param patience  the connection is closed where no answer comes within it
  template <class Request>
  TrackerTask<typename Request::Answer> ask(Request request, std::string_view what, Duration patience,
                                            Ends ends = {}) {
    const std::int64_t id = ++last_id_;
    std::string line = bridge::encode(id, request);
    const TrackerResult<boost::json::object> members =
        co_await answer_to(id, std::move(line), what, patience, std::move(ends));
    if (!members) co_return std::unexpected(members.error());
    auto answer = bridge::answer_of<Request>(*members);
    if (!answer) co_return std::unexpected(broken(std::string{Request::kName} + ": " + answer.error()));
    co_return *std::move(answer);
  }

 private:
  TrackerError broken(const std::string& why);
  TrackerTask<boost::json::object> answer_to(std::int64_t id, std::string line, std::string_view what,
                                             Duration patience, Ends ends);
  TrackerTask<bridge::FromBridge> receive();
  /// Whatever comes next, asking for a heartbeat where nothing does.
  TrackerTask<bridge::FromBridge> next_before(TimePoint deadline);

  TrackerWire wire_;
  std::function<void(const bridge::Event&)> observe_;
  control::LineSplitter lines_{bridge::kMaxLine};
  std::int64_t last_id_ = 0;
};

}  // namespace truepose::drivers
