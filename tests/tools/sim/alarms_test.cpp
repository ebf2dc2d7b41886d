#include "tools/sim/alarms.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <string>

#include "drivers/mock/virtual_clock.hpp"

namespace truepose::sim {
namespace {

using namespace std::chrono_literals;

class AlarmsTest : public testing::Test {
 protected:
  void at(drivers::Duration when, char name) {
    alarms_.at(drivers::TimePoint{when}, [this, name] { rung_ += name; });
  }
  void run() {
    clock_.run(io_, [] { return false; });
  }

  drivers::VirtualClock clock_;
  boost::asio::io_context io_{1};
  std::string rung_;
  Alarms alarms_{io_.get_executor(), clock_};
};

TEST_F(AlarmsTest, RingInTheOrderOfTheirTimesAndThoseOfThePastAtOnce) {
  clock_.pass_to(drivers::TimePoint{2s});
  at(4s, 'c');
  at(3s, 'b');
  at(1s, 'a');
  EXPECT_EQ(rung_, "");
  run();
  EXPECT_EQ(rung_, "abc");
  EXPECT_EQ(clock_.now(), drivers::TimePoint{4s});
}

TEST_F(AlarmsTest, DoNotRingOnceTheyAreCleared) {
  at(1s, 'a');
  alarms_.clear();
  at(2s, 'b');
  run();
  EXPECT_EQ(rung_, "b");
}

TEST_F(AlarmsTest, MayBeClearedAndSetByOneThatRings) {
  alarms_.at(drivers::TimePoint{1s}, [this] {
    alarms_.clear();
    at(3s, 'b');
  });
  at(2s, 'a');
  run();
  EXPECT_EQ(rung_, "b");
}

TEST_F(AlarmsTest, DoNotRingWhereTheyAreClearedBetweenTheirTimeAndTheirTurn) {
  at(1s, 'a');
  io_.poll();
  clock_.wake_first();
  alarms_.clear();
  run();
  EXPECT_EQ(rung_, "");
}

}  // namespace
}  // namespace truepose::sim
