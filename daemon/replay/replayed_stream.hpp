#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "daemon/threads/signal.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/wire_failure.hpp"

namespace truepose::daemon {

/// A connection to a device of which a recording tells: what came from it is put in by who replays, in its
/// order, and what the driver sends goes nowhere (its tap hears it).
class ReplayedStream final : public drivers::ByteStream {
 public:
  /// @param write_fails  whether the write that begins now ended with an error when it was recorded
  explicit ReplayedStream(std::function<bool()> write_fails) : write_fails_{std::move(write_fails)} {}

  void put_connected() { put({.operation = drivers::WireOperation::Connect, .error = {}, .bytes = {}}); }
  void put_received(std::string bytes);
  void put_failure(const drivers::WireFailure& failure);
  /// Whether the driver waits for the end of such an operation.
  bool awaits(drivers::WireOperation operation) const { return awaited_[index(operation)] > 0; }

  boost::asio::awaitable<boost::system::error_code> connect(std::string host, std::uint16_t port) override;
  boost::asio::awaitable<Received> read(std::span<char> into) override;
  boost::asio::awaitable<boost::system::error_code> write(std::string_view bytes) override;
  void close() noexcept override;
  bool is_open() const override { return open_; }

 private:
  /// The end of an operation.
  struct End {
    drivers::WireOperation operation;
    boost::system::error_code error;
    std::string bytes;  // that were read
  };
  class Awaiting;

  static std::size_t index(drivers::WireOperation operation) { return static_cast<std::size_t>(operation); }
  void put(End end);
  bool comes(drivers::WireOperation operation) const;
  boost::asio::awaitable<boost::system::error_code> until(drivers::WireOperation operation);

  std::function<bool()> write_fails_;
  std::deque<End> ends_;  // of connecting and reading, that the driver has not yet seen
  std::optional<boost::system::error_code> write_error_;
  std::array<int, drivers::kWireOperations.size()> awaited_{};
  bool open_ = false;
  unsigned closes_ = 0;
  Signal changed_;
};

}  // namespace truepose::daemon
