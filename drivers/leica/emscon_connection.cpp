#include "drivers/leica/emscon_connection.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/cancellation_state.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/system/system_error.hpp>
#include <utility>

#include "proto/emscon/status.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);

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

}  // namespace

TrackerError refusal(std::string_view what, std::int32_t status) {
  const TrackerFault fault = emscon::status::is_busy(status)        ? TrackerFault::Busy
                             : emscon::status::is_not_ready(status) ? TrackerFault::NotReady
                                                                    : TrackerFault::Refused;
  return {fault, std::string{what} + ": " + emscon::describe_status(status)};
}

EmsconConnection::EmsconConnection(asio::any_io_executor executor,
                                   std::function<void(const emscon::TrackerPacket&)> observe,
                                   WireTap tap)
    : socket_{std::move(executor)}, observe_{std::move(observe)}, tap_{std::move(tap)} {}

void EmsconConnection::close() noexcept {
  if (is_open()) tap_(recording::Kind::Closed, {});
  error_code ignored;
  socket_.close(ignored);
  splitter_ = {};
}

TrackerError EmsconConnection::lost(std::string_view why) {
  close();
  return {TrackerFault::Disconnected, "the connection to the tracker ended: " + std::string{why}};
}

TrackerTask<void> EmsconConnection::open(std::string host, std::uint16_t port) {
  close();
  CloseUnlessDone guard{*this};
  tcp::resolver resolver{socket_.get_executor()};
  const std::string service = std::to_string(port);
  auto [resolve_error, endpoints] = co_await resolver.async_resolve(host, service, kToResult);
  error_code error = resolve_error;
  if (!error) {
    auto [connect_error, endpoint] = co_await asio::async_connect(socket_, endpoints, kToResult);
    error = connect_error;
  }
  const asio::cancellation_state cancellation = co_await asio::this_coro::cancellation_state;
  throw_if_cancelled(cancellation);
  if (error) {
    co_return std::unexpected(TrackerError{
        TrackerFault::Unreachable, "no tracker answers at " + host + ":" + service + ": " + error.message()});
  }
  error_code ignored;
  socket_.set_option(tcp::no_delay{true}, ignored);
  tap_(recording::Kind::Connected, host + ":" + service);
  guard.done();
  co_return TrackerResult<void>{};
}

TrackerTask<void> EmsconConnection::send(emscon::Command command) {
  if (!is_open())
    co_return std::unexpected(TrackerError{TrackerFault::Disconnected, "the tracker is not connected"});
  const std::vector<std::uint8_t> bytes = emscon::encode(command);
  CloseUnlessDone guard{*this};  // half a packet sent cannot be taken back
  tap_(recording::Kind::Sent, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  auto [error, size] = co_await asio::async_write(socket_, asio::buffer(bytes), kToResult);
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
    auto [error, size] = co_await socket_.async_read_some(asio::buffer(received_), kToResult);
    const asio::cancellation_state cancellation = co_await asio::this_coro::cancellation_state;
    throw_if_cancelled(cancellation);
    if (error) co_return std::unexpected(lost(error.message()));
    tap_(recording::Kind::Received, {reinterpret_cast<const char*>(received_.data()), size});
    splitter_.push({received_.data(), size});
  }
}

TrackerTask<emscon::Answer> EmsconConnection::call(emscon::Command command) {
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

}  // namespace truepose::drivers
