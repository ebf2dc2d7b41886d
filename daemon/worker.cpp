#include "daemon/worker.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace truepose::daemon {

namespace asio = boost::asio;

namespace {

asio::awaitable<void> carry_out(std::function<void()> job) {
  job();
  co_return;
}

}  // namespace

asio::awaitable<void> Worker::run(std::function<void()> job) {
  auto token = asio::use_awaitable;
  co_await asio::co_spawn(pool_, carry_out(job), token);
}

}  // namespace truepose::daemon
