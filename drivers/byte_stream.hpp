#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace truepose::drivers {

/// In which a device that is there takes a connection.
inline constexpr std::chrono::seconds kTaken{2};

/// A connection to a device, over which bytes go. An operation that is cancelled ends with operation_aborted,
/// as a value.
class ByteStream {
 public:
  struct Received {
    boost::system::error_code error;
    std::size_t size = 0;
  };

  virtual ~ByteStream() = default;
  virtual boost::asio::awaitable<boost::system::error_code> connect(std::string host, std::uint16_t port) = 0;
  /// Waits for bytes, and takes as many as have come and fit.
  virtual boost::asio::awaitable<Received> read(std::span<char> into) = 0;
  /// @param bytes  outlive it
  virtual boost::asio::awaitable<boost::system::error_code> write(std::string_view bytes) = 0;
  virtual void close() noexcept = 0;
  virtual bool is_open() const = 0;
  /// "LOCAL REMOTE", each as "192.168.0.2:40000"; empty where that is not known.
  virtual std::string ends() const { return {}; }
};

using MakeStream = std::function<std::unique_ptr<ByteStream>(boost::asio::any_io_executor)>;

/// Over TCP. The system probes a connection on which nothing comes, in whatever state its owner is: one whose
/// other end went without a word (power, cable) ends within about 5 s, and what waits on it with an error.
std::unique_ptr<ByteStream> tcp_stream(boost::asio::any_io_executor executor);

}  // namespace truepose::drivers
