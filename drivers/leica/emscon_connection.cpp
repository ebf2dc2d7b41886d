#include "drivers/leica/emscon_connection.hpp"

#include <boost/asio/cancellation_state.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/system/system_error.hpp>
#include <utility>

#include "drivers/deadline.hpp"
#include "proto/emscon/status.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

/// Closes the connection unless the work it guards came to its end.
class CloseUnlessDone {
 public:
  explicit CloseUnlessDone(EmsconConnection& connection) : connection_{connection} {}
  ~CloseUnlessDone() {
    if (!done_) connection_.close();
  }
  CloseUnlessDone(const CloseUnlessDone&) = delete;
  CloseUnlessDone& operator=(const CloseUnlessDone&) = delete;
  void done() { done_ = true; }

 private:
  EmsconConnection& connection_;
  bool done_ = false;
};

/// Tells an operation aborted by cancellation from one whose socket was closed.
void throw_if_cancelled(const asio::cancellation_state& state) {
  if (state.cancelled() != asio::cancellation_type::none) {
    throw boost::system::system_error(asio::error::operation_aborted);
  }
}

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

EmsconConnection::EmsconConnection(std::unique_ptr<ByteStream> stream, Clock& clock,
                                   std::function<void(const emscon::TrackerPacket&)> observe, WireTap tap)
    : stream_{std::move(stream)}, clock_{clock}, observe_{std::move(observe)}, tap_{std::move(tap)} {}

void EmsconConnection::close() noexcept {
  if (is_open()) tap_(recording::Kind::Closed, {});
  stream_->close();
  splitter_ = {};
}

TrackerError EmsconConnection::lost(std::string_view why) {
  close();
  return {TrackerFault::Disconnected, "the connection to the tracker ended: " + std::string{why}};
}

TrackerTask<void> EmsconConnection::open(std::string host, std::uint16_t port) {
  close();
  CloseUnlessDone guard{*this};
  auto connecting = stream_->connect(host, port);
  const std::optional<error_code> error =
      co_await before(clock_, clock_.now() + kTaken, std::move(connecting));
  if (!error || *error) {
    const std::string why = error ? error->message() : "no answer to the connection request";
    co_return std::unexpected(TrackerError{TrackerFault::Unreachable, "no tracker answers at " + host + ":" +
                                                                          std::to_string(port) + ": " + why});
  }
  tap_(recording::Kind::Connected, host + ":" + std::to_string(port));
  guard.done();
  co_return TrackerResult<void>{};
}

TrackerTask<void> EmsconConnection::send(emscon::Command command) {
  if (!is_open())
    co_return std::unexpected(TrackerError{TrackerFault::Disconnected, "the tracker is not connected"});
  const std::vector<std::uint8_t> bytes = emscon::encode(command);
  CloseUnlessDone guard{*this};  // half a packet sent cannot be taken back
  tap_(recording::Kind::Sent, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const error_code error =
      co_await stream_->write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const asio::cancellation_state cancellation = co_await asio::this_coro::cancellation_state;
  throw_if_cancelled(cancellation);
  if (error) co_return std::unexpected(lost(error.message()));
  guard.done();
  co_return TrackerResult<void>{};
}

TrackerTask<emscon::TrackerPacket> EmsconConnection::receive() {
  for (;;) {
    if (!is_open()) co_return std::unexpected(lost("it is closed"));
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
    const auto [error, size] = co_await stream_->read(received_);
    const asio::cancellation_state cancellation = co_await asio::this_coro::cancellation_state;
    throw_if_cancelled(cancellation);
    if (error) co_return std::unexpected(lost(error.message()));
    tap_(recording::Kind::Received, {received_.data(), size});
    splitter_.push({reinterpret_cast<const std::uint8_t*>(received_.data()), size});
  }
}

TrackerTask<emscon::Answer> EmsconConnection::call(emscon::Command command) {
  const std::chrono::seconds given = patience(command.code);
  auto answering = answer_to(std::move(command));
  auto answer = co_await before(clock_, clock_.now() + given, std::move(answering));
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
