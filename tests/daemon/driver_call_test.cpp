#include "daemon/recorder/driver_call.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>

#include "daemon/recorder/made_driver.hpp"
#include "daemon/replay/same_outcome.hpp"
#include "drivers/wire_failure.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
using testing::HasSubstr;
using namespace std::chrono_literals;

TEST(ADriverCall, IsReadAgainToTheLastDigit) {
  DriverCall call{.number = 7, .asked = Asked::Move, .deadline = drivers::time_of(123'456'789)};
  call.move.q = JointVector{{0.1, 0.1 + 0.2, -1e-300, 1985.2248838698956, 5, 6}};
  call.move.speed_percent = 1.0 / 3;
  const auto again = read_call(text(call));
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->number, 7U);
  EXPECT_EQ(again->asked, Asked::Move);
  EXPECT_EQ(again->deadline, call.deadline);
  EXPECT_EQ(again->move.q, call.move.q);
  EXPECT_EQ(again->move.speed_percent, call.move.speed_percent);
  EXPECT_EQ(again->move.settle, call.move.settle);

  const DriverCall aim{.number = 8, .asked = Asked::Aim, .aim = {{0.1 + 0.2, 2, 3}, 30}};
  EXPECT_EQ(read_call(text(aim))->aim.p_W_mm, aim.aim.p_W_mm);
  const DriverCall average{.number = 9, .asked = Asked::AverageOver, .average = 1500ms};
  EXPECT_EQ(read_call(text(average))->average, average.average);
}

TEST(ADriverCall, ThatCannotBeReadSaysWhy) {
  EXPECT_THAT(read_call("{").error(), HasSubstr("call: "));
  EXPECT_THAT(read_call(R"({"call":1,"asked":"dance"})").error(), HasSubstr("dance"));
  const std::string many =
      R"({"q_rad":["1","2","3","4","5","6","7","8","9","1","2","3","4","5","6","7","8"],)"
      R"("speed_percent":"20","settle_ms":0})";
  EXPECT_THAT(read_call(R"({"call":1,"asked":"move","until_ns":0,"move":)" + many + "}").error(),
              HasSubstr("call.move.q_rad: expected as many"));
}

TEST(AnOutcome, SaysTheAnswerTheErrorOrThatTheCallWasCancelled) {
  using Moved = std::expected<JointVector, drivers::RobotError>;
  EXPECT_EQ(outcome_text(3, Moved{JointVector{{1, 2}}}), R"({"call":3,"answer":[1.0,2.0]})");
  EXPECT_EQ(
      outcome_text(4, Moved{std::unexpected(drivers::RobotError{drivers::RobotFault::Timeout, "late"})}),
      R"({"call":4,"failure":{"fault":"timeout","detail":"late"}})");
  const boost::system::system_error aborted{asio::error::operation_aborted};
  const auto cancelled = read_outcome(outcome_text(5, std::make_exception_ptr(aborted)));
  EXPECT_EQ(cancelled->call, 5U);
  EXPECT_TRUE(cancelled->cancelled);
  EXPECT_THAT(outcome_text(6, std::make_exception_ptr(std::runtime_error{"no memory"})),
              HasSubstr(R"("fault":"exception","detail":"no memory")"));
}

TEST(AnOutcome, IsTheSameButForLastDigits) {
  EXPECT_TRUE(same_outcome(R"({"call":1,"answer":[0.1]})", R"({"call":1,"answer":[0.1000000000001]})"));
  EXPECT_FALSE(same_outcome(R"({"call":1,"answer":[0.1]})", R"({"call":1,"answer":[0.1001]})"));
  EXPECT_FALSE(same_outcome(R"({"call":1,"answer":[0.1]})", R"({"call":1,"answer":[0.1,0.1]})"));
  EXPECT_FALSE(same_outcome(R"({"call":1,"answer":{}})", R"({"call":1,"failure":{}})"));
  EXPECT_FALSE(same_outcome(R"({"call":1})", "{"));
}

TEST(Air, IsReadAgainAsIsWhyNothingIsKnownOfIt) {
  const Air air{20.1, 1013.3, 0.1 + 0.2};
  EXPECT_EQ(**read_air(text(ToldAir{air})), air);
  EXPECT_EQ(read_air(text(ToldAir{std::unexpected("too old")}))->error(), "too old");
  EXPECT_FALSE(read_air("{}"));
}

TEST(AMadeDriver, IsReadAgainWithWhatItRemembers) {
  eki::Command command{.id = 3, .type = eki::CommandType::Ptp, .axes_rad = {0.1, 0.2, 0.1 + 0.2, 0, 0, 0}};
  const MadeRobot robot{.host = "10.0.0.1",
                        .motion_port = 54600,
                        .state_port = 54601,
                        .joint_count = 6,
                        .memory = {.last_id = 99, .unfinished = command}};
  const auto robot_again = read_robot(text(robot));
  ASSERT_TRUE(robot_again) << robot_again.error();
  EXPECT_EQ(robot_again->memory.unfinished, command);
  EXPECT_EQ(robot_again->memory.last_id, 99);

  MadeTracker tracker{.protocol = config::TrackerProtocol::Bridge, .host = "t", .measure = 2s};
  tracker.memory = drivers::TrackerMemory{.warm_up = {drivers::time_of(5), true},
                                          .average = 700ms,
                                          .last_request = 12,
                                          .distance_mm = 0.1 + 0.2,
                                          .turned_over = true};
  const auto tracker_again = read_tracker(text(tracker));
  ASSERT_TRUE(tracker_again) << tracker_again.error();
  EXPECT_EQ(text(*tracker_again), text(tracker));
  EXPECT_EQ(tracker_again->memory->distance_mm, tracker.memory->distance_mm);
}

TEST(AWireFailure, IsReadAgainWithItsMessage) {
  for (const boost::system::error_code error : {boost::system::error_code{asio::error::eof},
                                                {asio::error::connection_refused},
                                                {asio::error::host_not_found},
                                                {asio::error::service_not_found}}) {
    const auto again = drivers::read_failure(drivers::text({drivers::WireOperation::Connect, error}));
    ASSERT_TRUE(again) << again.error();
    EXPECT_EQ(again->error, error);
    EXPECT_EQ(again->error.message(), error.message());
  }
  for (const char* const wrong : {"", "read", "read system:x y", "write moon:3 dark", "dance system:3 no"})
    EXPECT_FALSE(drivers::read_failure(wrong)) << wrong;
}

}  // namespace
}  // namespace truepose::daemon
