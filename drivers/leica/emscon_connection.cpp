#include "drivers/leica/emscon_connection.hpp"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "core/planted_bug.hpp"
#include "drivers/deadline.hpp"
#include "proto/emscon/status.hpp"

namespace truepose::drivers {

namespace {

/// How long a tracker takes to answer at most: to what it only has to look up, and to what moves it.
std::chrono::seconds patience(emscon::CommandCode code) {
  using enum emscon::CommandCode;
  switch (code) {
    case Initialize:
      return std::chrono::seconds{120};
    case Park:
    case StartMeasurement:
    case StopMeasurement:
    case ChangeFace:
    case GoBirdBath:
    case GoBirdBath2:
    case CheckBirdBath:
    case GoPosition:
    case GoPositionHvd:
    case PositionRelativeHv:
    case PointLaser:
    case PointLaserHvd:
    case MoveHv:
    case GoLastMeasuredPoint:
    case FindReflector:
    case LookForTarget:
    case GoAndMeasure:
      return std::chrono::seconds{60};
    default:
      return std::chrono::seconds{3};
  }
}

}  // namespace

TrackerError refusal(std::string_view what, std::int32_t status) {
  const TrackerFault fault = emscon::status::is_busy(status)        ? TrackerFault::Busy
                             : emscon::status::is_not_ready(status) ? TrackerFault::NotReady
                                                                    : TrackerFault::Refused;
  return {fault, std::string{what} + ": " + emscon::describe_status(status)};
}

EmsconConnection::EmsconConnection(std::unique_ptr<net::Stream> stream, Clock& clock,
                                   std::function<void(const emscon::TrackerPacket&)> observe, WireTap tap)
    : wire_{std::move(stream), clock, std::move(tap)}, observe_{std::move(observe)} {}

void EmsconConnection::close() noexcept {
  wire_.close();
  if (!planted("half a packet of a lost connection is kept")) splitter_ = {};
}

TrackerTask<void> EmsconConnection::open(std::string host, std::uint16_t port) {
  close();
  auto opened = co_await wire_.open(std::move(host), port);
  co_return opened;
}

TrackerTask<void> EmsconConnection::send(emscon::Command command) {
  const std::vector<std::uint8_t> bytes = emscon::encode(command);
  std::string text{bytes.begin(), bytes.end()};
  auto sent = co_await wire_.send(std::move(text));
  co_return sent;
}

TrackerTask<emscon::TrackerPacket> EmsconConnection::receive() {
  for (;;) {
    if (!is_open() && !planted("half a packet of a lost connection is kept")) splitter_ = {};
    const auto bytes = splitter_.next();
    if (!bytes) {
      close();
      co_return std::unexpected(
          TrackerError{TrackerFault::Protocol,
                       "the tracker sent bytes that are not emScon: " + std::string{bytes.error().what}});
    }
    if (*bytes) {
      auto packet = emscon::decode_tracker_packet(**bytes);
      if (!packet) {
        close();
        co_return std::unexpected(TrackerError{
            TrackerFault::Protocol,
            "the tracker sent a packet that cannot be understood: " + std::string{packet.error().what} +
                " at byte " + std::to_string(packet.error().offset)});
      }
      const auto* error = std::get_if<emscon::ErrorReport>(&*packet);
      if (error != nullptr && error->status == emscon::status::kSecondConnectionRefused) {
        close();
        co_return std::unexpected(
            TrackerError{TrackerFault::Busy, "the tracker: " + emscon::describe_status(error->status)});
      }
      observe_(*packet);
      co_return *std::move(packet);
    }
    const auto received = co_await wire_.receive();
    if (!received) co_return std::unexpected(received.error());
    splitter_.push({reinterpret_cast<const std::uint8_t*>(received->data()), received->size()});
  }
}

TrackerTask<emscon::Answer> EmsconConnection::call(emscon::Command command) {
  const std::chrono::seconds given = patience(command.code);
  auto answering = answer_to(std::move(command));
  auto answer = co_await before(wire_.clock(), wire_.clock().now() + given, std::move(answering));
  if (answer) co_return *std::move(answer);
  co_return std::unexpected(TrackerError{
      TrackerFault::Timeout,
      "the tracker is connected and did not answer for " + std::to_string(given.count()) + " s"});
}

TrackerTask<emscon::Answer> EmsconConnection::answer_to(emscon::Command command) {
  const emscon::CommandCode code = command.code;
  CloseUnlessDone guard{*this};
  const auto sent = co_await send(std::move(command));
  if (!sent) co_return std::unexpected(sent.error());
  for (;;) {
    auto packet = co_await receive();
    if (!packet) co_return std::unexpected(packet.error());
    emscon::Answer* answer = std::get_if<emscon::Answer>(&*packet);
    if (answer != nullptr && answer->code == code) {
      guard.done();
      co_return std::move(*answer);
    }
    const emscon::ErrorReport* error = std::get_if<emscon::ErrorReport>(&*packet);
    if (error != nullptr && error->code == code && error->status != emscon::status::kAllOk) {
      guard.done();
      co_return emscon::Answer{code, error->status, {}};
    }
  }
}

TrackerTask<emscon::Answer> EmsconConnection::accepted(emscon::Command command, std::string_view what) {
  auto answer = co_await call(std::move(command));
  if (answer && answer->status != emscon::status::kAllOk)
    co_return std::unexpected(refusal(what, answer->status));
  co_return answer;
}

TrackerTask<emscon::Answer> EmsconConnection::ask(emscon::CommandCode code, std::string_view what) {
  emscon::Command command{code, {}};
  auto answer = co_await accepted(std::move(command), what);
  co_return answer;
}

}  // namespace truepose::drivers
