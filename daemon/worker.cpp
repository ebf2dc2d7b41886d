#include "daemon/worker.hpp"

#include <boost/asio/bind_cancellation_slot.hpp>
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
  // A job that has begun is carried out. Were the caller's cancellation passed on, it would reach into the
  // other thread's coroutine at whatever moment.
  auto token = asio::bind_cancellation_slot(asio::cancellation_slot{}, asio::use_awaitable);
  co_await asio::co_spawn(pool_, carry_out(job), token);
}

}  // namespace truepose::daemon
