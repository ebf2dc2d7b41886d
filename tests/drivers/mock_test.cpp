#include <gtest/gtest.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/arm/forward.hpp"
#include "drivers/mock/mock_robot.hpp"
#include "drivers/mock/mock_tracker.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "tests/daemon/example_cell.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

/// Runs one awaitable to its end in virtual time.
template <typename T>
T finish(asio::io_context& io, VirtualClock& clock, asio::awaitable<T> work) {
  std::optional<T> result;
  std::exception_ptr failed;
  asio::co_spawn(io, std::move(work), [&](std::exception_ptr e, T value) {
    failed = e;
    result.emplace(std::move(value));
  });
  EXPECT_TRUE(clock.run(io, [&] { return result.has_value(); }));
  if (failed) std::rethrow_exception(failed);
  return *std::move(result);
}

asio::awaitable<void> note(VirtualClock& clock, TimePoint when, std::string name,
                           std::vector<std::string>& order) {
  co_await clock.sleep_until(when);
  order.push_back(name);
}

TEST(VirtualClock, WakesSleepersInTheOrderOfTheirTimesThenOfTheirComing) {
  asio::io_context io;
  VirtualClock clock;
  std::vector<std::string> order;
  const TimePoint start = clock.now();
  asio::co_spawn(io, note(clock, start + 2h, "late", order), asio::detached);
  asio::co_spawn(io, note(clock, start + 1h, "first", order), asio::detached);
  asio::co_spawn(io, note(clock, start + 1h, "second", order), asio::detached);
  EXPECT_TRUE(clock.run(io, [&] { return order.size() == 3; }));
  EXPECT_EQ(order, (std::vector<std::string>{"first", "second", "late"}));
  EXPECT_EQ(clock.now() - start, 2h);
  EXPECT_EQ(clock.sleepers(), 0U);
}

TEST(VirtualClock, SaysWhenNothingIsLeftToWaitFor) {
  asio::io_context io;
  VirtualClock clock;
  EXPECT_FALSE(clock.run(io, [] { return false; }));
}

TEST(VirtualClock, ACancelledSleeperThrowsAndLeaves) {
  asio::io_context io;
  VirtualClock clock;
  asio::cancellation_signal cancel;
  std::exception_ptr thrown;
  bool ended = false;
  asio::co_spawn(io, clock.sleep_until(clock.now() + 1h),
                 asio::bind_cancellation_slot(cancel.slot(), [&](auto e) {
                   thrown = e;
                   ended = true;
                 }));
  io.poll();
  EXPECT_EQ(clock.sleepers(), 1U);
  cancel.emit(asio::cancellation_type::terminal);
  io.restart();
  io.poll();
  EXPECT_TRUE(ended);
  EXPECT_EQ(clock.sleepers(), 0U);
  EXPECT_EQ(clock.now(), TimePoint{});
  EXPECT_THROW(std::rethrow_exception(thrown), boost::system::system_error);
}

TEST(VirtualClock, ASleeperThatIsDestroyedIsForgotten) {
  VirtualClock clock;
  {
    asio::io_context io;
    asio::co_spawn(io, clock.sleep_until(clock.now() + 1h), asio::detached);
    io.poll();
    EXPECT_EQ(clock.sleepers(), 1U);
  }
  EXPECT_EQ(clock.sleepers(), 0U);
}

struct Mock : testing::Test {
  void make(MockFaults faults = {}) {
    MockCellOptions options = test::example_truth();
    options.faults = faults;
    options.seed = 1;
    cell.emplace(options, clock);
    robot.emplace(*cell);
    tracker.emplace(*cell);
    ASSERT_TRUE(finish(io, clock, robot->connect(in(10s))));
    ASSERT_TRUE(finish(io, clock, tracker->connect(in(180s))));
  }
  TimePoint in(Duration d) { return clock.now() + d; }
  std::expected<JointVector, RobotError> move(const JointVector& q) {
    MoveCommand command;
    command.q = q;
    command.speed_percent = 100;
    return finish(io, clock, robot->move(command, in(60s)));
  }
  std::expected<SmrPoint, TrackerError> look(double search_mm) {
    const auto aimed = finish(io, clock, tracker->aim(cell->p_WS_mm(), search_mm, in(60s)));
    if (!aimed) return std::unexpected(aimed.error());
    return finish(io, clock, tracker->measure(in(60s)));
  }

  asio::io_context io;
  VirtualClock clock;
  std::optional<MockCell> cell;
  std::optional<MockRobot> robot;
  std::optional<MockTracker> tracker;
};

TEST_F(Mock, AMoveTakesTheTimeOfTheSlowestJointAndTheSettling) {
  make();
  JointVector q = cell->q();
  q[0] += test::kr210().joints[0].speed * 1.0;
  const double travel_s = JointMotion{test::kr210(), cell->q(), q, 1}.duration().count();
  const TimePoint before = clock.now();
  const auto reached = move(q);
  ASSERT_TRUE(reached);
  EXPECT_EQ(*reached, q);
  EXPECT_NEAR(std::chrono::duration<double>(clock.now() - before).count(), travel_s + 0.5, 1e-6);
}

TEST_F(Mock, ATargetBeyondTheLimitsIsRefused) {
  make();
  JointVector q = cell->q();
  q[1] = 0;
  const auto reached = move(q);
  ASSERT_FALSE(reached);
  EXPECT_EQ(reached.error().fault, RobotFault::Refused);
}

TEST_F(Mock, TheTrackerReadsTheTrueReflectorNotTheNominalOne) {
  make();
  const auto point = look(30);
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - cell->p_WS_mm()).norm(), 0.1);
  const MockCellOptions& truth = cell->options();
  const Eigen::Vector3d nominal_mm =
      truth.truth.X_WB * forward_kinematics(truth.nominal, cell->q()) * truth.truth.p_FS_mm;
  EXPECT_GT((point->p_WS_mm - nominal_mm).norm(), 0.5);
}

TEST_F(Mock, EveryFaultIsAnErrorAndNeverAPoint) {
  struct Case {
    double MockFaults::*rate;
    TrackerFault expected;
  };
  const std::vector<Case> cases{{&MockFaults::tracker_busy, TrackerFault::Busy},
                                {&MockFaults::no_target, TrackerFault::NoTarget},
                                {&MockFaults::beam_broken, TrackerFault::BeamBroken}};
  for (const Case& c : cases) {
    MockFaults faults;
    faults.*(c.rate) = 1;
    make(faults);
    const auto point = look(30);
    ASSERT_FALSE(point);
    EXPECT_EQ(point.error().fault, c.expected);
  }
}

}  // namespace
}  // namespace truepose::drivers
