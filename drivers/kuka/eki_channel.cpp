#include "drivers/kuka/eki_channel.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/error.hpp>
#include <chrono>
#include <iterator>
#include <utility>

#include "core/planted_bug.hpp"
#include "drivers/deadline.hpp"
#include "drivers/wire_reports.hpp"
#include "proto/text/host_port.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// Refused, or reset where the controller closed its port in that moment.
bool is_not_taken(const std::optional<error_code>& result) {
  return result == asio::error::connection_refused || result == asio::error::connection_reset;
}

}  // namespace

EkiChannel::EkiChannel(std::unique_ptr<net::Stream> stream, Clock& clock, std::string name,
                       std::string server, std::string host, std::uint16_t port, WireTap tap)
    : stream_{std::move(stream)},
      clock_{clock},
      name_{std::move(name) + " at " + text::host_port(host, port)},
      server_{std::move(server)},
      host_{std::move(host)},
      port_{port},
      tap_{std::move(tap)} {}

asio::awaitable<std::expected<void, RobotError>> EkiChannel::connect(TimePoint deadline) {
  close();
  // A controller refuses until its program has seen the loss of the last client and reopened the channel.
  constexpr std::chrono::seconds kReopenPause{2};
  constexpr std::chrono::milliseconds kAgain{50};
  const TimePoint last_try = std::min(deadline, clock_.now() + kReopenPause) - kAgain;
  std::optional<error_code> result = co_await open(deadline);
  while (is_not_taken(result) && clock_.now() < last_try) {
    co_await clock_.sleep_until(clock_.now() + kAgain);
    result = co_await open(deadline);
  }
  if (!result) {
    co_return failed(RobotFault::Timeout,
                     "no answer to the connection request: check the address and that the controller is on");
  }
  if (*result == asio::error::connection_refused) {
    co_return failed(RobotFault::Unreachable,
                     "refused: check that " + server_ + " is running and that no other client is connected");
  }
  if (*result) co_return failed(RobotFault::Unreachable, result->message());
  report_connected(tap_, *stream_);
  co_return std::expected<void, RobotError>{};
}

asio::awaitable<std::optional<error_code>> EkiChannel::open(TimePoint deadline) {
  const TimePoint taken_by = std::min(deadline, clock_.now() + kTaken);
  auto connecting = stream_->connect(host_, port_);
  auto result = co_await before(clock_, taken_by, std::move(connecting));
  if (result) report_failure(tap_, "connect", *result);
  co_return result;
}

asio::awaitable<std::expected<void, RobotError>> EkiChannel::send(eki::ToController message,
                                                                  TimePoint deadline) {
  if (!connected()) co_return std::unexpected(not_connected());
  std::optional<error_code> error;
  try {
    error = co_await before(clock_, deadline, write(eki::encode(message)));
  } catch (...) {
    close();  // half a document may be on its way
    throw;
  }
  if (!error) co_return failed(RobotFault::Timeout, "the controller takes no more data: check " + server_);
  if (*error) co_return lost(*error);
  co_return std::expected<void, RobotError>{};
}

asio::awaitable<error_code> EkiChannel::write(std::string bytes) {
  tap_(recording::Kind::Sent, bytes);
  const error_code error = co_await stream_->write(bytes);
  report_failure(tap_, "write", error);
  co_return error;
}

asio::awaitable<std::expected<eki::FromController, RobotError>> EkiChannel::receive(TimePoint deadline) {
  if (!connected()) co_return std::unexpected(not_connected());
  for (;;) {
    if (!messages_.empty()) {
      eki::FromController message = std::move(messages_.front());
      messages_.pop_front();
      co_return message;
    }
    const auto document = splitter_.next();
    if (!document) co_return failed(RobotFault::Protocol, document.error());
    if (*document) {
      auto messages = eki::decode_from_controller(**document);
      if (!messages) co_return failed(RobotFault::Protocol, messages.error());
      std::ranges::move(*messages, std::back_inserter(messages_));
      continue;
    }
    const std::optional<error_code> error = co_await before(clock_, deadline, read());
    if (!error)
      co_return failed(RobotFault::Timeout, "connected but silent: check that " + server_ + " is running");
    if (*error) co_return lost(*error);
  }
}

asio::awaitable<error_code> EkiChannel::read() {
  std::array<char, 4096> bytes;
  const auto [error, size] = co_await stream_->read(bytes);
  if (size > 0) tap_(recording::Kind::Received, {bytes.data(), size});
  report_failure(tap_, "read", error);
  splitter_.feed({bytes.data(), size});
  co_return error;
}

void EkiChannel::close() noexcept {
  if (connected()) tap_(recording::Kind::Closed, {});
  stream_->close();
  if (planted("half a document of a lost connection is kept")) return;
  splitter_.reset();
  messages_.clear();
}

std::unexpected<RobotError> EkiChannel::failed(RobotFault fault, const std::string& what) {
  close();
  return std::unexpected(RobotError{fault, name_ + ": " + what});
}

std::unexpected<RobotError> EkiChannel::lost(const error_code& error) {
  return failed(RobotFault::Disconnected,
                error == asio::error::eof ? "the controller closed the connection" : error.message());
}

RobotError EkiChannel::not_connected() const { return {RobotFault::Disconnected, name_ + ": not connected"}; }

}  // namespace truepose::drivers
