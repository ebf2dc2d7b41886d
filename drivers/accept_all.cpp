#include "drivers/accept_all.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <utility>

namespace truepose::drivers {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;
using asio::ip::tcp;

namespace {

template <typename Acceptor>
asio::awaitable<void> accept_each(std::shared_ptr<Acceptor> acceptor,
                                  std::function<void(typename Acceptor::protocol_type::socket)> admit,
                                  Warn warn) {
  constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);
  while (acceptor->is_open()) {
    auto [error, socket] = co_await acceptor->async_accept(kToResult);
    if (!acceptor->is_open()) co_return;
    if (!error) {
      admit(std::move(socket));
      continue;
    }
    // Out of file descriptors, mostly: trying again at once would only burn the processor.
    warn("cannot accept a connection: " + error.message());
    asio::steady_timer later{acceptor->get_executor(), std::chrono::milliseconds{100}};
    co_await later.async_wait(asio::use_awaitable);
  }
}

}  // namespace

void accept_all(std::shared_ptr<tcp::acceptor> acceptor, std::function<void(tcp::socket)> admit, Warn warn) {
  const auto executor = acceptor->get_executor();
  asio::co_spawn(executor, accept_each(std::move(acceptor), std::move(admit), std::move(warn)),
                 asio::detached);
}

void accept_all(std::shared_ptr<Local::acceptor> acceptor, std::function<void(Local::socket)> admit,
                Warn warn) {
  const auto executor = acceptor->get_executor();
  asio::co_spawn(executor, accept_each(std::move(acceptor), std::move(admit), std::move(warn)),
                 asio::detached);
}

}  // namespace truepose::drivers
