#include "tools/steering/line_port.hpp"

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "proto/control/line_splitter.hpp"
#include "tools/steering/accept_clients.hpp"

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
    : acceptor_{
          std::make_shared<tcp::acceptor>(executor, tcp::endpoint{asio::ip::address_v4::loopback(), port})} {
  const auto admit = [executor,
                      shared = std::make_shared<const Answer>(std::move(answer))](tcp::socket socket) {
    asio::co_spawn(executor, serve(std::move(socket), shared), asio::detached);
  };
  accept_clients(acceptor_, "admin", admit);
}

LinePort::~LinePort() { acceptor_->close(); }

}  // namespace truepose::steering
