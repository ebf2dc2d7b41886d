#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace truepose {

/// No file can be opened while it is there.
class NoMoreFiles {
 public:
  NoMoreFiles() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit none{0, before_.rlim_max};
    ::setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoMoreFiles() { ::setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

/// How many steps an event loop takes, up to a thousand, while somebody has come to one of its ports and no
/// file can be opened for him: who tries again at once takes them all. Let the port have admitted somebody
/// before: a sanitizer, too, needs files when it meets a type for the first time, as here of timers and
/// errors.
inline std::size_t steps_without_files(boost::asio::io_context& io, boost::asio::ip::tcp::socket& client,
                                       std::uint16_t port) {
  boost::asio::steady_timer{io, std::chrono::seconds{0}}.async_wait([](boost::system::error_code) {});
  EXPECT_NE(make_error_code(boost::asio::error::no_descriptors).message(), "");
  while (io.poll_one() > 0) continue;
  client.connect({boost::asio::ip::address_v4::loopback(), port});
  const NoMoreFiles none;
  std::size_t steps = 0;
  while (steps < 1000 && io.poll_one() > 0) ++steps;
  return steps;
}

}  // namespace truepose
