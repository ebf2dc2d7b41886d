#include "tools/steering/line_port.hpp"

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <utility>

#include "proto/control/line_splitter.hpp"

namespace truepose::steering {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

asio::awaitable<void> serve(tcp::socket socket, std::shared_ptr<const LinePort::Answer> answer) {
  constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);
  control::LineSplitter lines{control::kMaxLine};
  std::array<char, 4096> buffer;
  while (!lines.overflowed()) {
    auto [ended, size] = co_await socket.async_read_some(asio::buffer(buffer), kToResult);
    if (ended) co_return;
    lines.push({buffer.data(), size});
    while (const auto line = lines.next()) {
      const std::string reply = (*answer)(*line) + "\n";
      auto [lost, sent] = co_await asio::async_write(socket, asio::buffer(reply), kToResult);
      if (lost) co_return;
    }
  }
}

}  // namespace

LinePort::LinePort(const asio::any_io_executor& executor, std::uint16_t port, Answer answer)
    : acceptor_{executor, {asio::ip::address_v4::loopback(), port}},
      again_{executor},
      answer_{std::make_shared<const Answer>(std::move(answer))} {
  accept();
}

void LinePort::accept() {
  acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) return accept_later();
    asio::co_spawn(acceptor_.get_executor(), serve(std::move(socket), answer_), asio::detached);
    accept();
  });
}

/// Out of file descriptors, mostly: trying again at once would only burn the processor.
void LinePort::accept_later() {
  again_.expires_after(std::chrono::milliseconds{100});
  again_.async_wait([this](boost::system::error_code stopped) {
    if (!stopped) accept();
  });
}

}  // namespace truepose::steering
