#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/net/stream.hpp"
#include "drivers/tracker.hpp"
#include "drivers/wire_tap.hpp"

namespace truepose::drivers {

template <class T>
using TrackerResult = std::expected<T, TrackerError>;
template <class T>
using TrackerTask = boost::asio::awaitable<TrackerResult<T>>;

/// Bytes over one connection to a tracker. After Disconnected it is closed. Every operation that is cancelled
/// throws operation_aborted; one that was left in the midst of its bytes has closed the connection.
class TrackerWire {
 public:
  /// @param clock  outlives it
  TrackerWire(std::unique_ptr<net::Stream> stream, Clock& clock, WireTap tap)
      : stream_{std::move(stream)}, clock_{clock}, tap_{std::move(tap)} {}

  TrackerTask<void> open(std::string host, std::uint16_t port);
  bool is_open() const { return stream_->is_open(); }
  void close() noexcept;

  TrackerTask<void> send(std::string bytes);
  /// What has come, at least a byte; valid until the next call.
  TrackerTask<std::string_view> receive();

  Clock& clock() { return clock_; }

 private:
  TrackerError lost(std::string_view why);

  std::unique_ptr<net::Stream> stream_;
  Clock& clock_;
  WireTap tap_;
  std::array<char, 4096> received_{};
};

/// Closes a connection unless the work that it guards came to its end.
template <class Connection>
class CloseUnlessDone {
 public:
  explicit CloseUnlessDone(Connection& connection) : connection_{connection} {}
  ~CloseUnlessDone() {
    if (!done_) connection_.close();
  }
  CloseUnlessDone(const CloseUnlessDone&) = delete;
  CloseUnlessDone& operator=(const CloseUnlessDone&) = delete;
  void done() { done_ = true; }

 private:
  Connection& connection_;
  bool done_ = false;
};

}  // namespace truepose::drivers
