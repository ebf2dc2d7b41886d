#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <chrono>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/leica/emscon_tracker.hpp"
#include "tests/drivers/leica/alarm_clock.hpp"
#include "tests/drivers/leica/fake_tracker.hpp"

namespace truepose::drivers {

/// The driver before a tracker whose answers a test may script.
class EmsconTrackerTest : public testing::Test {
 protected:
  template <class T>
  T run(boost::asio::awaitable<T> call) {
    std::optional<T> result;
    std::exception_ptr thrown;
    boost::asio::co_spawn(
        io, std::move(call),
        boost::asio::bind_cancellation_slot(cancel.slot(), [&](std::exception_ptr error, T value) {
          thrown = error;
          result = std::move(value);
        }));
    while (!result) io.run_one();
    if (thrown) std::rethrow_exception(thrown);
    return *std::move(result);
  }

  auto connect() { return run(tracker.connect({})); }
  auto aim(double radius_mm = 50) { return run(tracker.aim({1000, 2000, -500}, radius_mm, {})); }
  auto measure() { return run(tracker.measure({})); }

  void expect_fault(const auto& outcome, TrackerFault fault) {
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().fault, fault) << outcome.error().detail;
    EXPECT_FALSE(outcome.error().detail.empty());
  }
  void expect_point(double x_mm = 1000) {
    const auto point = measure();
    ASSERT_TRUE(point) << point.error().detail;
    EXPECT_EQ(point->p_WS_mm, Eigen::Vector3d(x_mm, 2000, -500));
  }
  auto count(emscon::CommandCode code) {
    return std::count(fake.commands.begin(), fake.commands.end(), code);
  }

  std::vector<std::pair<recording::Kind, std::string>> heard;
  boost::asio::io_context io;
  boost::asio::cancellation_signal cancel;
  FakeTracker fake{io};
  AlarmClock clock{io};
  EmsconOptions options{
      .host = "127.0.0.1",
      .port = fake.port(),
      .reflector = "RRR-0.5in",
      .measure = std::chrono::milliseconds{1500},
      .tap = [this](recording::Kind kind, std::string_view bytes) { heard.emplace_back(kind, bytes); }};
  EmsconTracker tracker{io.get_executor(), clock, options};
};

}  // namespace truepose::drivers
