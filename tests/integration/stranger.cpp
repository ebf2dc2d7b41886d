#include "tests/integration/stranger.hpp"

#include <netinet/in.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

namespace truepose {

namespace asio = boost::asio;
using asio::ip::make_address;
using asio::ip::tcp;
using boost::system::error_code;

bool Stranger::connect() {
  if (socket_ && !ended()) return true;
  hang_up();
  socket_.emplace(context_);
  error_code failed;
  socket_->open(tcp::v4());
  // The port is chosen when it connects: else ports run out, and strangers come from everybody's address.
  const int later = 1;
  ::setsockopt(socket_->native_handle(), IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, &later, sizeof later);
  socket_->bind({make_address(way_.from), 0}, failed);
  if (!failed) socket_->connect({make_address(way_.to), way_.port}, failed);
  if (!failed && way_.over_tls) {
    tls_.emplace(*socket_, tls_context_);
    tls_->handshake(asio::ssl::stream_base::client, failed);
  }
  if (failed) hang_up();
  return !failed;
}

void Stranger::send(std::string_view bytes) {
  error_code failed;
  if (tls_)
    asio::write(*tls_, asio::buffer(bytes), failed);
  else
    asio::write(*socket_, asio::buffer(bytes), failed);
  if (failed) hang_up();
}

void Stranger::hang_up() {
  tls_.reset();
  socket_.reset();
}

/// What comes is of no interest, nor understood.
bool Stranger::ended() {
  error_code failed;
  char byte = 0;
  socket_->non_blocking(true);
  socket_->receive(asio::buffer(&byte, 1), 0, failed);
  socket_->non_blocking(false);
  return failed && failed != asio::error::would_block;
}

std::uint64_t hold_200(const Way& way, std::string_view bytes, const std::stop_token& stop) {
  std::vector<std::unique_ptr<Stranger>> strangers;
  for (int i = 0; i < 200; ++i) strangers.push_back(std::make_unique<Stranger>(way));
  std::uint64_t sent = 0;
  while (!stop.stop_requested()) {
    for (const auto& stranger : strangers) {
      if (!stranger->connect()) continue;
      stranger->send(bytes);
      ++sent;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{100});
  }
  return sent;
}

std::uint64_t connect_again_and_again(const Way& way, const std::stop_token& stop) {
  Stranger stranger{way};
  std::uint64_t connects = 0;
  while (!stop.stop_requested()) {
    connects += stranger.connect();
    stranger.hang_up();
  }
  return connects;
}

std::uint64_t send_lines_of_1_MB(const Way& way, const std::stop_token& stop) {
  const std::string line(1'000'000, 'x');
  Stranger stranger{way};
  std::uint64_t lines = 0;
  while (!stop.stop_requested()) {
    if (!stranger.connect()) continue;
    stranger.send(line);
    ++lines;
  }
  return lines;
}

}  // namespace truepose
