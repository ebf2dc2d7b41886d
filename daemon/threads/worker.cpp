#include "daemon/threads/worker.hpp"

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "core/step_count.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;

asio::awaitable<void> Worker::carry_out(std::function<void()> job, Given) {
  step_count = &beats_;
  count_step();
  job();
  co_return;
}

Pulse Worker::pulse() const { return {beats_, given_ == 0}; }

asio::awaitable<void> Worker::run(std::function<void()> job) {
  // A job that has begun is carried out. Were the caller's cancellation passed on, it would reach into the
  // other thread's coroutine at whatever moment.
  auto token = asio::bind_cancellation_slot(asio::cancellation_slot{}, asio::use_awaitable);
  // Not begun where the caller is cancelled already: the coroutine and its count are gone with it.
  Given given{given_};
  co_await asio::co_spawn(pool_, carry_out(job, std::move(given)), token);
}

}  // namespace truepose::daemon
