#include "daemon/replay/replayed_stream.hpp"

#include <algorithm>
#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>
#include <utility>

namespace truepose::daemon {

namespace asio = boost::asio;
using boost::system::error_code;
using drivers::WireOperation;

class ReplayedStream::Awaiting {
 public:
  Awaiting(ReplayedStream& stream, WireOperation operation) : count_{stream.awaited_[index(operation)]} {
    ++count_;
  }
  ~Awaiting() { --count_; }
  Awaiting(const Awaiting&) = delete;
  Awaiting& operator=(const Awaiting&) = delete;

 private:
  int& count_;
};

void ReplayedStream::put(End end) {
  ends_.push_back(std::move(end));
  changed_.notify();
}

void ReplayedStream::put_received(std::string bytes) {
  put({.operation = WireOperation::Read, .error = {}, .bytes = std::move(bytes)});
}

void ReplayedStream::put_failure(const drivers::WireFailure& failure) {
  if (failure.operation != WireOperation::Write)
    return put({.operation = failure.operation, .error = failure.error, .bytes = {}});
  write_error_ = failure.error;
  changed_.notify();
}

bool ReplayedStream::comes(WireOperation operation) const {
  if (operation == WireOperation::Write) return write_error_.has_value();
  return !ends_.empty() && ends_.front().operation == operation;
}

/// Returns when the end of the operation has been put in; the error says that the driver has closed the
/// connection before, or cancelled.
asio::awaitable<error_code> ReplayedStream::until(WireOperation operation) {
  const Awaiting awaiting{*this, operation};
  const unsigned closes = closes_;
  try {
    while (closes_ == closes && !comes(operation)) co_await changed_.wait();
  } catch (const boost::system::system_error& cancelled) {
    co_return cancelled.code();
  }
  co_return closes_ == closes ? error_code{} : asio::error::operation_aborted;
}

asio::awaitable<error_code> ReplayedStream::connect(std::string, std::uint16_t) {
  close();
  open_ = true;  // as a socket is that is not yet connected
  const error_code given_up = co_await until(WireOperation::Connect);
  if (given_up) co_return given_up;
  const error_code error = ends_.front().error;
  ends_.pop_front();
  // Of a name that could not be resolved there is no socket.
  open_ = !error || error.category() == asio::error::get_system_category();
  co_return error;
}

asio::awaitable<ReplayedStream::Received> ReplayedStream::read(std::span<char> into) {
  if (!open_) co_return Received{asio::error::bad_descriptor, 0};
  const error_code given_up = co_await until(WireOperation::Read);
  if (given_up) co_return Received{given_up, 0};
  End& end = ends_.front();
  const Received received{end.error, std::min(into.size(), end.bytes.size())};
  std::ranges::copy_n(end.bytes.begin(), static_cast<std::ptrdiff_t>(received.size), into.begin());
  end.bytes.erase(0, received.size);
  if (end.bytes.empty()) ends_.pop_front();
  co_return received;
}

asio::awaitable<error_code> ReplayedStream::write(std::string_view) {
  if (!open_) co_return asio::error::bad_descriptor;
  if (!write_fails_()) co_return error_code{};
  const error_code given_up = co_await until(WireOperation::Write);
  if (given_up) co_return given_up;
  co_return *std::exchange(write_error_, std::nullopt);
}

void ReplayedStream::close() noexcept {
  open_ = false;
  ++closes_;
  write_error_.reset();
  // What came over this connection is lost, what is of the next one is not.
  while (!ends_.empty() && ends_.front().operation != WireOperation::Connect) ends_.pop_front();
  changed_.notify();
}

}  // namespace truepose::daemon
