// Aborts at any instant of a campaign, with the real drivers over connections in memory and in virtual time.
#include <gmock/gmock.h>

#include <boost/asio/detached.hpp>
#include <map>

#include "core/math/random.hpp"
#include "drivers/kuka/eki_robot.hpp"
#include "drivers/leica/emscon_tracker.hpp"
#include "tests/daemon/cell_fixture.hpp"
#include "tests/daemon/wired_devices.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

struct AbortedCampaignTest : CellTest {
  AbortedCampaignTest() {
    config.campaign.remeasure = false;
    network.latency = 30ms;
  }

  asio::awaitable<Answer> ask_wired(std::string method) {
    auto asked = wired.call(std::move(method), {}, kOperator);
    auto answer = co_await std::move(asked);
    co_return answer;
  }

  drivers::MemoryNetwork network{io, clock};
  WiredController controller{network, mock};
  WiredTracker wired_tracker{io, network, mock};
  drivers::KukaEkiRobot real_robot{io.get_executor(),
                                   clock,
                                   {.host = "controller",
                                    .motion_port = WiredController::kMotion,
                                    .state_port = WiredController::kState,
                                    .stream = network.streams()}};
  drivers::EmsconTracker real_tracker{
      io.get_executor(),
      clock,
      {.host = "tracker", .port = WiredTracker::kPort, .stream = network.streams()}};
  DaemonCell wired{{io.get_executor(), config, real_robot, real_tracker, clock, *stream, *store, store_thread,
                    compute_thread, events, recorder, recorder_thread, wall_clock}};
};

// From every phase and at every await: from before the devices are connected to behind the last pose.
TEST_F(AbortedCampaignTest, LeavesACellThatIsReadyWheneverItComes) {
  const int aborts = all_trials() ? 1000 : 100;
  Random random{20261128};
  std::map<std::string, int> phases;
  asio::cancellation_signal end;
  asio::co_spawn(io, wired.watch(), asio::bind_cancellation_slot(end.slot(), asio::detached));
  over = false;
  const auto script = [&]() -> Wait {
    const TimePoint begun = clock.now();
    co_await ask_wired("campaign.start");
    for (auto now = co_await ask_wired("cell.status"); !now->at("campaign").is_null();
         now = co_await ask_wired("cell.status"))
      co_await pass(10ms);
    const std::chrono::duration<double> whole = (clock.now() - begun) * 0.9;
    for (int n = 0; n < aborts; ++n) {
      SCOPED_TRACE(n);
      const Answer started = co_await ask_wired("campaign.start");
      EXPECT_TRUE(started) << started.error().message;
      if (!started) co_return;
      // As many in the first seconds, in which it connects and proves the arm, as later.
      const double longest_s = n % 2 == 0 ? 20 : whole.count();
      co_await pass(std::chrono::milliseconds{static_cast<int>(random.uniform(0, longest_s) * 1e3)});
      const Answer aborted = co_await ask_wired("campaign.abort");
      EXPECT_TRUE(aborted) << aborted.error().message;
      if (aborted) ++phases[std::string{aborted->at("phase").as_string()}];
      EXPECT_FALSE(mock.moving());
      co_await pass(6s);  // in which each device is asked whether it is there
      const Answer now = co_await ask_wired("cell.status");
      EXPECT_EQ(now->at("state"), "ready") << now->at("state_text");
      EXPECT_EQ(fault_of(*now), "");
      if (n % 5 == 4) co_await ask_wired("cell.disconnect");
    }
  };
  asio::co_spawn(io, script, [&](std::exception_ptr failed) {
    over = true;
    EXPECT_FALSE(failed);
  });
  ASSERT_TRUE(clock.run(io, [&] { return over; }));
  end.emit(asio::cancellation_type::terminal);
  real_robot.disconnect();
  real_tracker.disconnect();
  clock.run(io, [] { return false; });
  EXPECT_EQ(phases["aborted"], aborts);
}

}  // namespace
}  // namespace truepose::daemon
