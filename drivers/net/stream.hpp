#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/system/error_code.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace truepose::net {

/// A connection, over which bytes go. One read and one write may be under way at a time. An operation that is
/// cancelled ends with operation_aborted, as a value.
class Stream {
 public:
  struct Received {
    boost::system::error_code error;
    std::size_t size = 0;
  };
  struct End {
    std::string host;  ///< a numeric address; empty where it is not known
    std::uint16_t port = 0;
  };

  virtual ~Stream() = default;
  virtual boost::asio::any_io_executor executor() = 0;
  virtual boost::asio::awaitable<boost::system::error_code> connect(std::string host, std::uint16_t port) = 0;
  /// Waits for bytes, and takes as many as have come and fit.
  virtual boost::asio::awaitable<Received> read(std::span<char> into) = 0;
  /// @param bytes  outlive it
  virtual boost::asio::awaitable<boost::system::error_code> write(std::string_view bytes) = 0;
  /// The other end learns that nothing more comes.
  virtual boost::asio::awaitable<void> end_writing() = 0;
  /// Ends the read under way.
  virtual void end_reading() = 0;
  virtual void close() noexcept = 0;
  virtual bool is_open() const = 0;
  virtual End local() const { return {}; }
  virtual End remote() const { return {}; }
  /// Of the system's socket; -1 where there is none.
  virtual int handle() const { return -1; }
};

using MakeStream = std::function<std::unique_ptr<Stream>(boost::asio::any_io_executor)>;

/// Over TCP, to connect to a device. The system probes a connection on which nothing comes, in whatever state
/// its owner is: one whose other end went without a word (power, cable) ends within about 5 s, and what waits
/// on it with an error.
std::unique_ptr<Stream> tcp_stream(boost::asio::any_io_executor executor);

/// Has the system ask after so much silence whether the other end is still there, and end the connection
/// where it is not.
void keep_alive(const Stream& stream, int silence_s, int again_s, int times);
/// What is written goes out at once, however little it is.
void send_at_once(const Stream& stream);
/// Whether the other end has gone, and left nothing to read.
bool has_left(const Stream& stream);
/// Takes what has come, without waiting. @return bytes
std::size_t read_waiting(const Stream& stream, std::span<char> into);
/// Both ways first, so that an end that still sends sees an end and not a reset.
void close_in_order(Stream& stream) noexcept;
/// So that the other end sees a reset.
void reset(Stream& stream) noexcept;

}  // namespace truepose::net
