#pragma once

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tests/daemon/control_fixture.hpp"

namespace truepose::daemon::test {

/// What a server answered.
struct HttpAnswer {
  int status = 0;
  std::string header;  ///< with the status line
  std::string body;
};

/// A blocking HTTP client that sends given bytes.
class HttpClient {
 public:
  explicit HttpClient(std::uint16_t port, int receive_buffer = 0) {
    socket_.open(tcp::v4());
    if (receive_buffer > 0) socket_.set_option(tcp::socket::receive_buffer_size{receive_buffer});
    const timeval limit{.tv_sec = 30, .tv_usec = 0};
    ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    socket_.connect({asio::ip::address_v4::loopback(), port});
  }
  void send(std::string_view bytes) {
    boost::system::error_code gone;
    asio::write(socket_, asio::buffer(bytes), gone);
  }
  /// @param more  lines of the header, each with its end
  void ask(const std::string& method, const std::string& target, const std::string& more = "") {
    send(method + " " + target + " HTTP/1.1\r\nHost: 127.0.0.1:7280\r\n" + more + "\r\n");
  }
  /// @param has_body  an answer to HEAD has none, whatever its header says
  HttpAnswer answer(bool has_body = true) {
    HttpAnswer answer;
    answer.header = until("\r\n\r\n");
    if (answer.header.empty()) return answer;
    answer.status = std::stoi(answer.header.substr(9, 3));
    const std::size_t length = answer.header.find("Content-Length: ");
    if (has_body && length != std::string::npos)
      answer.body = read(std::stoul(answer.header.substr(length + 16)));
    return answer;
  }
  HttpAnswer get(const std::string& target, const std::string& more = "") {
    ask("GET", target, more);
    return answer();
  }
  bool closed() { return read(1).empty(); }
  tcp::socket& socket() { return socket_; }

  /// So many bytes; fewer where the server closed.
  std::string read(std::size_t size) {
    boost::system::error_code end;
    if (buffer_.size() < size)
      asio::read(socket_, asio::dynamic_buffer(buffer_), asio::transfer_exactly(size - buffer_.size()), end);
    return taken(std::min(size, buffer_.size()));
  }

 private:
  std::string until(const std::string& end) {
    boost::system::error_code gone;
    const std::size_t size = asio::read_until(socket_, asio::dynamic_buffer(buffer_), end, gone);
    return gone ? "" : taken(size);
  }
  std::string taken(std::size_t size) {
    std::string taken = buffer_.substr(0, size);
    buffer_.erase(0, size);
    return taken;
  }

  asio::io_context context_;
  tcp::socket socket_{context_};
  std::string buffer_;
};

/// A client over WebSocket, written from RFC 6455 for these tests.
class WebSocketClient : public ProtocolClient {
 public:
  /// @param more  lines of the header of its handshake, each with its end
  explicit WebSocketClient(std::uint16_t port, const std::string& more = "", int receive_buffer = 0)
      : http_{port, receive_buffer} {
    http_.ask("GET", "/rpc",
              "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                  more);
    handshake_ = http_.answer();
  }
  const HttpAnswer& handshake() const { return handshake_; }

  /// A message for each line.
  void send(std::string_view lines) override {
    for (; !lines.empty(); lines.remove_prefix(std::min(lines.size(), lines.find('\n') + 1)))
      send_frame(kText, lines.substr(0, lines.find('\n')));
  }
  void send_frame(std::uint8_t operation, std::string_view payload) {
    http_.send(frame(static_cast<std::uint8_t>(0x80U | operation), payload));
  }
  void send_bytes(std::string_view bytes) { http_.send(bytes); }
  /// As clients have to send it: masked.
  static std::string frame(std::uint8_t first, std::string_view payload) {
    constexpr std::array<char, 4> kMask{0x12, 0x34, 0x56, 0x78};
    std::string frame(1, static_cast<char>(first));
    if (payload.size() < 126) {
      frame += static_cast<char>(0x80U | payload.size());
    } else {
      const bool is_long = payload.size() > 0xffff;
      frame += static_cast<char>(is_long ? 0xff : 0xfe);
      for (int shift = is_long ? 56 : 8; shift >= 0; shift -= 8)
        frame += static_cast<char>(payload.size() >> static_cast<unsigned>(shift));
    }
    frame.append(kMask.data(), kMask.size());
    for (std::size_t i = 0; i < payload.size(); ++i) frame += static_cast<char>(payload[i] ^ kMask[i % 4]);
    return frame;
  }

  /// The next text message; empty where the server said that it closes, or closed.
  std::string any_line() override {
    for (Frame next = next_frame(); next.operation != kClose; next = next_frame())
      if (next.operation == kText) return next.payload;
    return {};
  }
  /// What a ping is answered with, whatever else is answered later; empty where it closed.
  std::string next_pong() {
    while (true) {
      const Frame next = next_frame();
      if (next.operation == kPong || next.operation == kClose) return pong_;
    }
  }
  const std::string& pong() const { return pong_; }
  /// What the server said as it closed: a code of two bytes, and why.
  const std::string& farewell() const { return farewell_; }

  static constexpr std::uint8_t kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10;

 private:
  struct Frame {
    std::uint8_t operation;
    std::string payload;
  };
  /// A server that closed without a word is one that closes.
  Frame next_frame() {
    const std::string head = http_.read(2);
    if (head.size() < 2) return {kClose, {}};
    const auto operation = static_cast<std::uint8_t>(head[0] & 0x0f);
    std::uint64_t size = static_cast<std::uint8_t>(head[1]);
    if (size > 125) {
      const std::string longer = http_.read(size == 126 ? 2 : 8);
      size = 0;
      for (const char byte : longer) size = size << 8U | static_cast<std::uint8_t>(byte);
    }
    Frame frame{operation, http_.read(size)};
    if (operation == kPong) pong_ = frame.payload;
    if (operation == kClose) farewell_ = frame.payload;
    return frame;
  }

  HttpClient http_;
  HttpAnswer handshake_;
  std::string pong_, farewell_;
};

}  // namespace truepose::daemon::test
