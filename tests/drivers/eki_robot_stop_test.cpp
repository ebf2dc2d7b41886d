#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "tests/drivers/eki_controller.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

TEST_F(EkiRobot, StopsAndReleasesTheStopOnlyWhenTheArmStands) {
  int left = 3;
  serve({greet_and_answer({})}, answer_by([&](const eki::Control& control) {
          eki::State state = ready_state(control.id);
          state.moving = controls_.size() > 1 && left > 0;
          if (state.moving) --left;
          return std::vector{state};
        }));
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto stopped = co_await robot.stop(soon());
    EXPECT_TRUE(stopped) << stopped.error().detail;
  });
  using enum eki::ControlOp;
  EXPECT_THAT(controls_, testing::ElementsAre(ReleaseStop, Stop, AskState, AskState, AskState, ReleaseStop));
}

TEST_F(EkiRobot, SaysThatTheArmStillMovesAndNotThatTheControllerIsSilent) {
  state_.moving = true;
  serve({greet_and_answer({})});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto stopped = co_await robot.stop(clock_.now() + 3s);
    EXPECT_EQ(stopped ? "" : stopped.error().detail, "the arm still moves after the order to stop");
  });
}

TEST_F(EkiRobot, StopsWhileAStateIsAwaitedAndBothGetTheirAnswers) {
  std::int32_t asked = 0;
  serve({greet_and_answer({})}, answer_by([&](const eki::Control& control) -> std::vector<eki::State> {
          if (control.op == eki::ControlOp::AskState) {
            asked = control.id;  // answered only behind the answer to the stop
            return {};
          }
          if (control.op == eki::ControlOp::Stop) return {ready_state(control.id), ready_state(asked)};
          return {ready_state(control.id)};
        }));
  int answered = 0;
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto ask = [&]() -> asio::awaitable<void> {
      const auto state = co_await robot.state(soon());
      EXPECT_TRUE(state) << state.error().detail;
      ++answered;
    };
    const auto executor = co_await asio::this_coro::executor;
    asio::co_spawn(executor, ask(), asio::detached);
    while (std::ranges::count(controls_, eki::ControlOp::AskState) == 0) {
      co_await asio::post(executor, asio::use_awaitable);
    }
    const auto stopped = co_await robot.stop(soon());
    EXPECT_TRUE(stopped) << stopped.error().detail;
    while (answered == 0) co_await asio::post(executor, asio::use_awaitable);
  });
  EXPECT_EQ(answered, 1);
}

TEST_F(EkiRobot, StopsOverANewConnectionWhereItHasLostTheOneBefore) {
  serve({greet_and_answer({})}, [&](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    for (;;) {
      const eki::ToController message = co_await peer->read();
      const auto& control = std::get<eki::Control>(message);
      controls_.push_back(control.op);
      if (controls_.size() == 2) co_return peer->close();
      co_await peer->write(text(ready_state(control.id)));
    }
  });
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    EXPECT_FALSE(co_await robot.state(soon()));
    const auto stopped = co_await robot.stop(soon());
    EXPECT_TRUE(stopped) << stopped.error().detail;
  });
  using enum eki::ControlOp;
  EXPECT_THAT(controls_, testing::ElementsAre(ReleaseStop, AskState, Stop, ReleaseStop));
}

TEST_F(EkiRobot, ThrowsWhenAMoveIsCancelledAndCanStillBeStopped) {
  bool moving = false;
  serve({[&](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    co_await peer->write(text(kHello));
    co_await peer->read();
    moving = true;
    co_await peer->read();
  }});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    asio::cancellation_signal cancel;
    const auto executor = co_await asio::this_coro::executor;
    std::exception_ptr ended;
    bool done = false;
    const auto move = [&]() -> asio::awaitable<void> { co_await robot.move({target()}, soon()); };
    asio::co_spawn(executor, move(),
                   asio::bind_cancellation_slot(cancel.slot(), [&](std::exception_ptr error) {
                     ended = error;
                     done = true;
                   }));
    while (!moving) co_await asio::post(executor, asio::use_awaitable);
    cancel.emit(asio::cancellation_type::terminal);
    while (!done) co_await asio::post(executor, asio::use_awaitable);
    EXPECT_TRUE(ended);
    if (!ended) co_return;
    try {
      std::rethrow_exception(ended);
    } catch (const boost::system::system_error& error) {
      EXPECT_EQ(error.code(), asio::error::operation_aborted);
    }
    const auto stopped = co_await robot.stop(soon());
    EXPECT_TRUE(stopped) << stopped.error().detail;
  });
}

}  // namespace
}  // namespace truepose::drivers
