#include "drivers/tracker_wire.hpp"

#include <boost/asio/cancellation_state.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/system/system_error.hpp>
#include <optional>

#include "drivers/deadline.hpp"
#include "drivers/wire_reports.hpp"
#include "proto/text/host_port.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

/// Tells an operation aborted by cancellation from one whose socket was closed.
void throw_if_cancelled(const asio::cancellation_state& state) {
  if (state.cancelled() != asio::cancellation_type::none) {
    throw boost::system::system_error(asio::error::operation_aborted);
  }
}

}  // namespace

void TrackerWire::close() noexcept {
  if (is_open()) tap_(recording::Kind::Closed, {});
  stream_->close();
}

TrackerError TrackerWire::lost(std::string_view why) {
  close();
  return {TrackerFault::Disconnected, "the connection to the tracker ended: " + std::string{why}};
}

TrackerTask<void> TrackerWire::open(std::string host, std::uint16_t port) {
  close();
  CloseUnlessDone guard{*this};
  auto connecting = stream_->connect(host, port);
  const std::optional<error_code> error =
      co_await before(clock_, clock_.now() + kTaken, std::move(connecting));
  if (error) report_failure(tap_, "connect", *error);
  if (!error || *error) {
    const std::string why = error ? error->message() : "no answer to the connection request";
    co_return std::unexpected(TrackerError{
        TrackerFault::Unreachable, "no tracker answers at " + text::host_port(host, port) + ": " + why});
  }
  report_connected(tap_, *stream_);
  guard.done();
  co_return TrackerResult<void>{};
}

TrackerTask<void> TrackerWire::send(std::string bytes) {
  if (!is_open())
    co_return std::unexpected(TrackerError{TrackerFault::Disconnected, "the tracker is not connected"});
  CloseUnlessDone guard{*this};  // half a message sent cannot be taken back
  tap_(recording::Kind::Sent, bytes);
  const error_code error = co_await stream_->write(bytes);
  report_failure(tap_, "write", error);
  const asio::cancellation_state cancellation = co_await asio::this_coro::cancellation_state;
  throw_if_cancelled(cancellation);
  if (error) co_return std::unexpected(lost(error.message()));
  guard.done();
  co_return TrackerResult<void>{};
}

TrackerTask<std::string_view> TrackerWire::receive() {
  if (!is_open()) co_return std::unexpected(lost("it is closed"));
  const auto [error, size] = co_await stream_->read(received_);
  report_failure(tap_, "read", error);
  const asio::cancellation_state cancellation = co_await asio::this_coro::cancellation_state;
  throw_if_cancelled(cancellation);
  if (error) co_return std::unexpected(lost(error.message()));
  const std::string_view bytes{received_.data(), size};
  tap_(recording::Kind::Received, bytes);
  co_return bytes;
}

}  // namespace truepose::drivers
