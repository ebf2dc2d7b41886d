#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "drivers/net/listener.hpp"
#include "drivers/net/stream.hpp"

namespace truepose::net {

/// How connections are made: by the system, or within the process.
struct Network {
  MakeStream stream = tcp_stream;
  std::function<Result<std::shared_ptr<Listener>>(const boost::asio::any_io_executor&, const std::string&,
                                                  std::uint16_t, ListenOptions)>
      listen_tcp = net::listen_tcp;
  std::function<Result<std::unique_ptr<HeldPort>>(const boost::asio::any_io_executor&, const std::string&,
                                                  std::uint16_t)>
      hold_tcp = net::hold_tcp;
  std::function<Result<std::shared_ptr<Listener>>(const boost::asio::any_io_executor&,
                                                  const std::filesystem::path&, unsigned)>
      listen_local = net::listen_local;
};

}  // namespace truepose::net
