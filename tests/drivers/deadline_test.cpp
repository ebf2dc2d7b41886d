#include "drivers/deadline.hpp"

#include <gtest/gtest.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/system/system_error.hpp>
#include <functional>
#include <stdexcept>

#include "drivers/clock.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

asio::awaitable<int> seven() { co_return 7; }

asio::awaitable<int> failing() {
  throw std::runtime_error{"broken"};
  co_return 0;
}

/// Never ends by itself; a cancellation is thrown, or reported as the value -1.
asio::awaitable<int> endless(Clock& clock, bool as_value) {
  try {
    co_await clock.sleep_until(TimePoint::max());
  } catch (const boost::system::system_error&) {
    if (!as_value) throw;
  }
  co_return -1;
}

class Deadline : public testing::Test {
 protected:
  /// Races the operation and returns what the caller sees; throws what it throws.
  std::optional<int> race(std::function<asio::awaitable<int>()> operation, TimePoint deadline) {
    std::optional<int> result;
    std::exception_ptr thrown;
    const auto body = [&]() -> asio::awaitable<void> {
      result = co_await before(clock_, deadline, operation());
    };
    asio::co_spawn(
        context_, body(),
        asio::bind_cancellation_slot(cancel_.slot(), [&](std::exception_ptr error) { thrown = error; }));
    if (cancel_at_once_)
      asio::post(context_,
                 [&] { asio::post(context_, [&] { cancel_.emit(asio::cancellation_type::terminal); }); });
    context_.run();
    if (thrown) std::rethrow_exception(thrown);
    return result;
  }

  TimePoint never() const { return TimePoint::max(); }

  SteadyClock clock_;
  asio::io_context context_;
  asio::cancellation_signal cancel_;
  bool cancel_at_once_ = false;
};

TEST_F(Deadline, GivesWhatTheOperationReturned) { EXPECT_EQ(race(seven, never()), 7); }

TEST_F(Deadline, PassesOnWhatTheOperationThrewWithoutWaiting) {
  EXPECT_THROW(race(failing, never()), std::runtime_error);
}

TEST_F(Deadline, EndsTheOperationAndGivesNothing) {
  for (const bool as_value : {false, true}) {
    context_.restart();
    EXPECT_EQ(race([&] { return endless(clock_, as_value); }, clock_.now() + 1ms), std::nullopt);
  }
}

TEST_F(Deadline, ThrowsWhenTheCallerIsCancelled) {
  cancel_at_once_ = true;
  for (const bool as_value : {false, true}) {
    context_.restart();
    try {
      race([&] { return endless(clock_, as_value); }, never());
      ADD_FAILURE() << "nothing was thrown";
    } catch (const boost::system::system_error& error) {
      EXPECT_EQ(error.code(), asio::error::operation_aborted);
    }
  }
}

}  // namespace
}  // namespace truepose::drivers
