#include "daemon/threads/worker.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <future>
#include <stdexcept>

#include "core/step_count.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;

// Under the thread sanitizer this shows what otherwise crashes once in many runs.
TEST(Worker, CarriesOutAJobWhoseCallerIsCancelledAtAnyMoment) {
  for (int trial = 0; trial < trials(2000); ++trial) {
    asio::io_context io;
    Worker worker;  // whose thread lets go of the loop a moment after it has answered
    asio::cancellation_signal cancel;
    std::atomic<bool> done = false;
    std::atomic<int> spun = 0;
    bool done_when_ended = false, ended = false;
    auto caller = [&]() -> asio::awaitable<void> {
      std::function<void()> job = [&] {
        for (int i = 0; i < 100 * (trial % 50); ++i) spun = i;
        done = true;
      };
      co_await worker.run(job);
      done_when_ended = done;
    };
    asio::co_spawn(io, caller(), asio::bind_cancellation_slot(cancel.slot(), [&](std::exception_ptr) {
                     ended = true;
                     if (!done_when_ended) done_when_ended = done;
                   }));
    while (!ended) {
      io.poll();
      cancel.emit(asio::cancellation_type::terminal);
    }
    EXPECT_TRUE(done_when_ended) << trial;
  }
}

TEST(Worker, ShowsItsStepsWhileItWorksAndThatItIsIdleAfterwards) {
  asio::io_context io;
  Worker worker;
  EXPECT_TRUE(worker.pulse().idle);
  std::promise<void> begun, go_on;
  auto caller = [&]() -> asio::awaitable<void> {
    std::function<void()> job = [&] {
      begun.set_value();
      go_on.get_future().wait();
      count_step();
      throw std::runtime_error{"also of a job that fails"};
    };
    co_await worker.run(job);
  };
  bool failed = false;
  asio::co_spawn(io, caller(), [&](std::exception_ptr error) { failed = error != nullptr; });
  io.poll();
  begun.get_future().wait();
  const Pulse before = worker.pulse();
  EXPECT_FALSE(before.idle);
  EXPECT_EQ(worker.pulse().beats, before.beats);  // it stands still
  go_on.set_value();
  worker.join();
  io.run();
  EXPECT_TRUE(failed);
  EXPECT_GT(worker.pulse().beats, before.beats);
  EXPECT_TRUE(worker.pulse().idle);
}

TEST(Worker, IsIdleWhereACancelledCallerNeverGaveItsJob) {
  asio::io_context io;
  Worker worker;
  asio::cancellation_signal cancel;
  bool asked = false;
  auto caller = [&]() -> asio::awaitable<void> {
    asio::steady_timer never{io, asio::steady_timer::time_point::max()};
    const auto waited = co_await never.async_wait(asio::as_tuple(asio::use_awaitable));
    static_cast<void>(waited);
    asked = true;
    std::function<void()> job = [] {};
    co_await worker.run(job);
  };
  asio::co_spawn(io, caller(), asio::bind_cancellation_slot(cancel.slot(), asio::detached));
  io.poll();
  cancel.emit(asio::cancellation_type::terminal);
  io.run();
  worker.join();
  EXPECT_TRUE(asked);
  EXPECT_TRUE(worker.pulse().idle);
}

}  // namespace
}  // namespace truepose::daemon
