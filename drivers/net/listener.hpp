#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/system/error_code.hpp>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "drivers/net/stream.hpp"

namespace truepose::net {

template <class T>
using Result = std::expected<T, boost::system::error_code>;

/// Where connections arrive. From its start on they wait until they are accepted.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual boost::asio::any_io_executor executor() = 0;
  virtual boost::asio::awaitable<Result<std::unique_ptr<Stream>>> accept() = 0;
  virtual void close() noexcept = 0;
  virtual bool is_open() const = 0;
  /// Where it listens; of a Unix socket nothing.
  virtual Stream::End local() const = 0;
};

/// A port that is taken before anything listens on it: until then it refuses connections.
class HeldPort {
 public:
  virtual ~HeldPort() = default;
  virtual std::uint16_t port() const = 0;
};

struct ListenOptions {
  bool shares_port = false;  ///< with a HeldPort
};

/// Over TCP, at a numeric address. The port may still have connections that are closing.
/// @param port  0 picks a free one
Result<std::shared_ptr<Listener>> listen_tcp(const boost::asio::any_io_executor& executor,
                                             const std::string& address, std::uint16_t port,
                                             ListenOptions options = {});

/// Takes a port of TCP on which no program listens, for listeners that share it.
/// @param port  0 picks a free one
Result<std::unique_ptr<HeldPort>> hold_tcp(const boost::asio::any_io_executor& executor,
                                           const std::string& address, std::uint16_t port);

/// At a Unix socket, which must not be there yet.
/// @param mode  of the file, before the first client can connect
Result<std::shared_ptr<Listener>> listen_local(const boost::asio::any_io_executor& executor,
                                               const std::filesystem::path& path, unsigned mode);

/// Of why no connection can be accepted: "cannot accept a connection: Too many open files".
using Warn = std::function<void(const std::string&)>;

/// Accepts on the listener's executor until the listener is closed.
/// @param listener  kept until then, as is what it may be a part of
void accept_all(std::shared_ptr<Listener> listener, std::function<void(std::unique_ptr<Stream>)> admit,
                Warn warn);

}  // namespace truepose::net
