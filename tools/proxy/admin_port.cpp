#include "tools/proxy/admin_port.hpp"

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/object.hpp>

#include "proto/control/json_text.hpp"
#include "proto/control/line_splitter.hpp"

namespace truepose::proxy {

namespace asio = boost::asio;
namespace json = boost::json;
using asio::ip::tcp;

namespace {

json::object reply_to(Proxy& proxy, const std::string& line) {
  const auto command = parse_command(line);
  if (!command) return {{"error", command.error()}};
  if (command->at) return {{"error", "at_ms belongs into a timeline"}};
  return proxy.obey(*command);
}

asio::awaitable<void> serve(tcp::socket socket, Proxy& proxy) {
  constexpr auto kToReplyResult = asio::as_tuple(asio::use_awaitable);
  control::LineSplitter lines{control::kMaxLine};
  std::array<char, 4096> buffer;
  while (!lines.overflowed()) {
    auto [ended, size] = co_await socket.async_read_some(asio::buffer(buffer), kToReplyResult);
    if (ended) co_return;
    lines.push({buffer.data(), size});
    while (const auto line = lines.next()) {
      const std::string reply = control::json_text(reply_to(proxy, *line)) + "\n";
      auto [lost, sent] = co_await asio::async_write(socket, asio::buffer(reply), kToReplyResult);
      if (lost) co_return;
    }
  }
}

}  // namespace

AdminPort::AdminPort(const asio::any_io_executor& executor, std::uint16_t port, Proxy& proxy)
    : acceptor_{executor, {asio::ip::address_v4::loopback(), port}}, proxy_{proxy} {
  accept();
}

void AdminPort::accept() {
  acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) asio::co_spawn(acceptor_.get_executor(), serve(std::move(socket), proxy_), asio::detached);
    accept();
  });
}

}  // namespace truepose::proxy
