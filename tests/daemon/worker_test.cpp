#include "daemon/worker.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;

// Under the thread sanitizer this shows what otherwise crashes once in many runs.
TEST(Worker, CarriesOutAJobWhoseCallerIsCancelledAtAnyMoment) {
  for (int trial = 0; trial < 2000; ++trial) {
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

}  // namespace
}  // namespace truepose::daemon
