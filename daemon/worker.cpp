#include "daemon/worker.hpp"

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "core/step_count.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;

void Worker::carry_out(const std::function<void()>& job) {
  // Also where it throws: the watchdog must not wait for it.
  struct Counted {
    Worker& worker;
    explicit Counted(Worker& of) : worker{of} {
      step_count = &worker.beats_;
      count_step();
    }
    ~Counted() {
      count_step();
      --worker.waiting_;
    }
  };
  const Counted counted{*this};
  job();
}

Pulse Worker::pulse() const { return {beats_, waiting_ == 0}; }

asio::awaitable<void> Worker::run(std::function<void()> job) {
  // A job that has begun is carried out. Were the caller's cancellation passed on, it would reach into the
  // other thread's coroutine at whatever moment.
  auto token = asio::bind_cancellation_slot(asio::cancellation_slot{}, asio::use_awaitable);
  const auto carried_out = [this, job = std::move(job)]() -> asio::awaitable<void> {
    carry_out(job);
    co_return;
  };
  ++waiting_;
  co_await asio::co_spawn(pool_, carried_out, token);
}

}  // namespace truepose::daemon
