#include "drivers/bridge/bridge_connection.hpp"

#include <algorithm>
#include <utility>

#include "drivers/deadline.hpp"

namespace truepose::drivers {

namespace {

constexpr std::chrono::seconds kHeartbeat{2};  // of silence, before the bridge is asked whether it lives
constexpr std::chrono::seconds kAlive{3};      // in which it answers that

TrackerFault fault_of(bridge::ErrorCode code) {
  using enum bridge::ErrorCode;
  switch (code) {
    case Busy:
      return TrackerFault::Busy;
    case NotReady:
    case WarmingUp:
    case NotInitialised:
    case DeviceLost:
      return TrackerFault::NotReady;
    case NoTarget:
      return TrackerFault::NoTarget;
    case BeamBroken:
      return TrackerFault::BeamBroken;
    case WrongProtocol:
      return TrackerFault::Protocol;
    case UnknownReflector:
    case OutOfRange:
    case Stopped:
    case NotOffered:
    case BadRequest:
    case Failed:
      break;
  }
  return TrackerFault::Refused;
}

}  // namespace

TrackerError refusal(std::string_view what, const bridge::Refusal& refusal) {
  const std::string text = refusal.text.empty() ? "" : refusal.text + " ";
  return {fault_of(refusal.meaning()), std::string{what} + ": " + text + "(" + refusal.code + ")"};
}

BridgeConnection::BridgeConnection(std::unique_ptr<net::Stream> stream, Clock& clock,
                                   std::function<void(const bridge::Event&)> observe, WireTap tap)
    : wire_{std::move(stream), clock, std::move(tap)}, observe_{std::move(observe)} {}

void BridgeConnection::close() noexcept {
  wire_.close();
  lines_ = control::LineSplitter{bridge::kMaxLine};
}

TrackerError BridgeConnection::broken(const std::string& why) {
  close();
  return {TrackerFault::Protocol, "the bridge sent what cannot be understood: " + why};
}

TrackerTask<void> BridgeConnection::open(std::string host, std::uint16_t port) {
  close();
  auto opened = co_await wire_.open(std::move(host), port);
  co_return opened;
}

TrackerTask<bridge::FromBridge> BridgeConnection::receive() {
  for (;;) {
    if (const auto line = lines_.next()) {
      auto message = bridge::decode_from_bridge(*line);
      if (!message) co_return std::unexpected(broken(message.error()));
      if (const auto* event = std::get_if<bridge::Event>(&*message)) observe_(*event);
      co_return *std::move(message);
    }
    if (lines_.overflowed()) co_return std::unexpected(broken("a line of more than 64 KiB"));
    const auto received = co_await wire_.receive();
    if (!received) {
      close();
      co_return std::unexpected(received.error());
    }
    lines_.push(*received);
  }
}

TrackerTask<bridge::FromBridge> BridgeConnection::next_before(TimePoint deadline) {
  Clock& clock = wire_.clock();
  for (bool asked = false;;) {
    const Duration patience = asked ? Duration{kAlive} : Duration{kHeartbeat};
    const TimePoint until = std::min(deadline, clock.now() + patience);
    auto receiving = receive();
    auto message = co_await before(clock, until, std::move(receiving));
    if (message) co_return *std::move(message);
    if (asked || clock.now() >= deadline) break;
    std::string ping = bridge::encode(++last_id_, bridge::Ping{}) + "\n";
    const auto sent = co_await wire_.send(std::move(ping));
    if (!sent) co_return std::unexpected(sent.error());
    asked = true;
  }
  const bool dead = clock.now() < deadline;
  close();
  co_return std::unexpected(TrackerError{
      TrackerFault::Timeout, dead ? "the bridge is connected and does not answer its heartbeat: restart it"
                                  : "the tracker is connected and did not answer in its time"});
}

TrackerTask<boost::json::object> BridgeConnection::answer_to(std::int64_t id, std::string line,
                                                             std::string_view what, Duration patience,
                                                             Ends ends) {
  const TimePoint deadline = wire_.clock().now() + patience;
  line += '\n';
  const auto sent = co_await wire_.send(std::move(line));
  if (!sent) co_return std::unexpected(sent.error());
  for (;;) {
    auto message = co_await next_before(deadline);
    if (!message) co_return std::unexpected(message.error());
    if (const auto* event = std::get_if<bridge::Event>(&*message)) {
      if (!ends) continue;
      if (auto ended = ends(*event)) co_return std::unexpected(*std::move(ended));
      continue;
    }
    auto& reply = std::get<bridge::Reply>(*message);
    if (!reply.id)
      co_return std::unexpected(broken("it could not read a request: " + reply.outcome.error().text));
    if (*reply.id > last_id_)
      co_return std::unexpected(
          broken("an answer to request " + std::to_string(*reply.id) + ", which was never made"));
    if (*reply.id != id) continue;  // of one that was left, or a heartbeat
    if (!reply.outcome) co_return std::unexpected(refusal(what, reply.outcome.error()));
    co_return std::move(*reply.outcome);
  }
}

}  // namespace truepose::drivers
