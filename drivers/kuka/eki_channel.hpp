#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <deque>
#include <expected>
#include <memory>
#include <optional>
#include <string>

#include "drivers/clock.hpp"
#include "drivers/net/stream.hpp"
#include "drivers/robot.hpp"
#include "drivers/wire_tap.hpp"
#include "proto/eki/document_splitter.hpp"
#include "proto/eki/messages.hpp"

namespace truepose::drivers {

/// One TCP connection to an EKI channel: documents out, messages in. Every error names the channel and its
/// address, and closes the connection, since a stream that was given up in the middle cannot be trusted
/// again.
class EkiChannel {
 public:
  /// @param name    "CellLink"
  /// @param server  what answers there, for the operator: "the robot program truepose_motion"
  EkiChannel(std::unique_ptr<net::Stream> stream, Clock& clock, std::string name, std::string server,
             std::string host, std::uint16_t port, WireTap tap = kNullTap);

  boost::asio::awaitable<std::expected<void, RobotError>> connect(TimePoint deadline);
  boost::asio::awaitable<std::expected<void, RobotError>> send(eki::ToController message, TimePoint deadline);
  /// The next message, whatever it is.
  boost::asio::awaitable<std::expected<eki::FromController, RobotError>> receive(TimePoint deadline);
  void close() noexcept;
  bool connected() const { return stream_->is_open(); }

 private:
  boost::asio::awaitable<std::optional<boost::system::error_code>> open(TimePoint deadline);
  boost::asio::awaitable<boost::system::error_code> write(std::string bytes);
  boost::asio::awaitable<boost::system::error_code> read();
  std::unexpected<RobotError> failed(RobotFault fault, const std::string& what);
  std::unexpected<RobotError> lost(const boost::system::error_code& error);
  RobotError not_connected() const;

  std::unique_ptr<net::Stream> stream_;
  Clock& clock_;
  std::string name_;  // "CellLink at 192.168.1.5:54600"
  std::string server_;
  std::string host_;
  std::uint16_t port_;
  WireTap tap_;
  eki::DocumentSplitter splitter_;
  std::deque<eki::FromController> messages_;  // received, not yet asked for
};

}  // namespace truepose::drivers
