#include "daemon/cell/cell_runner.hpp"

#include <gmock/gmock.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>

#include "config/text_file.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct CellRunnerTest : testing::Test {
  CellRunnerTest() {
    runner.on(CellCommand::CloseDevices, [this](const std::string&) { done.emplace_back("close devices"); });
    runner.on(CellCommand::StopStream, [this](const std::string&) { done.emplace_back("stop stream"); });
    runner.on(CellCommand::AbortCampaign,
              [this](const std::string& why) { done.push_back("abort: " + why); });
    runner.on(CellCommand::PauseCampaign, [this](const std::string&) { done.emplace_back("pause"); });
    runner.on(CellCommand::ResumeCampaign, [this](const std::string&) { done.emplace_back("resume"); });
    runner.explain_by([] { return "no datagram came"; });
  }
  std::vector<json::value> event_data(control::Topic topic) {
    std::vector<json::value> data;
    const auto reader = events.subscribe({topic}, 0, [] {});
    for (const EventBus::Line& line : reader->take(100).lines)
      data.push_back(std::get<control::Event>(control::decode_server_line(*line).value()).data);
    return data;
  }
  /// Lets time pass for the watch.
  void pass(Duration time) {
    asio::cancellation_signal end;
    asio::co_spawn(io, runner.watch(), asio::bind_cancellation_slot(end.slot(), asio::detached));
    bool over = false;
    asio::co_spawn(io, clock.sleep_until(clock.now() + time), [&](std::exception_ptr) { over = true; });
    EXPECT_TRUE(clock.run(io, [&] { return over; }));
    end.emit(asio::cancellation_type::terminal);
    while (io.poll_one() > 0) continue;
  }
  void start_stream() {
    runner.apply(ConnectRequested{}, "");
    runner.apply(DevicesConnected{}, "");
    runner.apply(StreamStartRequested{}, "");
  }

  asio::io_context io;
  drivers::VirtualClock clock;
  drivers::WallClock wall_clock = [this] {
    return std::chrono::system_clock::time_point{
        std::chrono::duration_cast<std::chrono::system_clock::duration>(clock.now().time_since_epoch())};
  };
  EventBus events{{1, 1'000'000, [] {}}, wall_clock};
  CellRunner runner{clock, events, wall_clock, {.campaign_waiting = 120s}};
  std::vector<std::string> done;
};

TEST_F(CellRunnerTest, TellsClientsOfEachStateAndWhyItCame) {
  runner.apply(ConnectRequested{}, "asked for by an operator", "Anna");
  EXPECT_EQ(runner.name(), "connecting");
  EXPECT_EQ(runner.reason(), "asked for by an operator");
  ASSERT_EQ(event_data(control::Topic::Cell).size(), 1U);
  EXPECT_EQ(
      control::json_text(event_data(control::Topic::Cell)[0]),
      R"({"state":"connecting","from":"disconnected","reason":"asked for by an operator","by":"Anna"})");
}

TEST_F(CellRunnerTest, RefusesWhatTheStateDoesNotAllowAndChangesNothing) {
  const auto refused = runner.apply(StreamStartRequested{}, "asked for by an operator");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, control::ErrorCode::WrongState);
  EXPECT_EQ(refused->state, "disconnected");
  EXPECT_THAT(refused->allowed, ElementsAre("cell.connect", "campaign.start", "drift.check", "stream.arm"));
  EXPECT_EQ(runner.name(), "disconnected");
  EXPECT_THAT(event_data(control::Topic::Cell), IsEmpty());
}

TEST_F(CellRunnerTest, HasTheCommandsOfAStepCarriedOutInTheirOrder) {
  runner.apply(CampaignStartRequested{"c1"}, "");
  runner.apply(CampaignAbortRequested{}, "asked for");
  runner.apply(StoreFailed{{"store: disk full"}}, "the campaign ended");
  EXPECT_THAT(done, ElementsAre("abort: asked for", "close devices"));
}

TEST_F(CellRunnerTest, AFaultStandsUntilItIsAcknowledged) {
  runner.apply(ConnectRequested{}, "");
  runner.apply(ConnectFailed{{"robot: gone", "look at its cable"}}, "");
  EXPECT_TRUE(runner.faults().stands(FaultCode::Cell));
  EXPECT_EQ(runner.reason(), "robot: gone; look at its cable, then acknowledge the fault and connect");
  EXPECT_FALSE(runner.apply(AcknowledgeRequested{}, "acknowledged"));
  EXPECT_FALSE(runner.faults().stands(FaultCode::Cell));
  const auto faults = event_data(control::Topic::Fault);
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_EQ(faults[0].at("active"), true);
  EXPECT_EQ(faults[1].at("active"), false);
  EXPECT_EQ(faults[1].at("text"), faults[0].at("text"));
}

TEST_F(CellRunnerTest, AllowsToAcknowledgeAStoreThatFailsInEveryState) {
  runner.faults().begin({FaultCode::Store, "store: disk full"});
  EXPECT_THAT(runner.allowed(), testing::Contains("cell.acknowledge"));
  EXPECT_EQ(runner.next(), "Make room, then acknowledge and resume.");
  runner.faults().end(FaultCode::Store);
  EXPECT_THAT(runner.allowed(), testing::Not(testing::Contains("cell.acknowledge")));
}

TEST_F(CellRunnerTest, EndsAStateThatHasLastedTooLongAtThatMoment) {
  start_stream();
  pass(30s - 1ms);
  EXPECT_EQ(runner.name(), "streaming");
  pass(1ms);
  EXPECT_EQ(runner.name(), "fault");
  EXPECT_TRUE(runner.faulted_in_stream());
  EXPECT_THAT(runner.reason(),
              testing::StartsWith("no RSI packet could be answered: no datagram came; then"));
  EXPECT_THAT(done, ElementsAre("stop stream", "close devices"));
}

TEST_F(CellRunnerTest, CountsTheTimeOfAStateFromItsOwnBeginning) {
  pass(1h);
  start_stream();
  pass(20s);
  runner.apply(StreamProgramStarted{}, "");
  pass(4s - 1ms);
  EXPECT_EQ(runner.name(), "streaming");
  pass(1ms);
  EXPECT_EQ(runner.name(), "fault");
}

TEST_F(CellRunnerTest, DoesNotLookAtTheClockWhileNoStateHasAnEnd) {
  pass(1h);
  EXPECT_EQ(clock.sleepers(), 0U);
}

TEST_F(CellRunnerTest, WakesWhoWaitsForTheEndOfAState) {
  runner.apply(ConnectRequested{}, "");
  bool woken = false;
  asio::co_spawn(io, runner.while_in<Connecting>(), [&](std::exception_ptr) { woken = true; });
  EXPECT_FALSE(clock.run(io, [&] { return woken; })) << "nothing is left that time alone would change";
  runner.apply(DeviceAwaited{CellDevice::Tracker, "it has to connect"}, "");
  EXPECT_FALSE(clock.run(io, [&] { return woken; })) << "it still connects";
  runner.apply(DevicesConnected{}, "");
  EXPECT_TRUE(clock.run(io, [&] { return woken; }));
}

TEST_F(CellRunnerTest, WaitsNoLongerThanItsTimeout) {
  TimePoint woken{};
  asio::co_spawn(io, runner.changed_until(TimePoint{10s}), [&](std::exception_ptr failed) {
    EXPECT_FALSE(failed);
    woken = clock.now();
  });
  EXPECT_TRUE(clock.run(io, [&] { return woken != TimePoint{}; }));
  EXPECT_EQ(woken, TimePoint{10s});
}

TEST_F(CellRunnerTest, TellsThatACampaignHasLostADeviceThatItPausesForItAndThatItIsBack) {
  runner.apply(CampaignStartRequested{"c1"}, "asked for by an operator");
  runner.await(CellDevice::Tracker, "tracker: it restarted");
  pass(40s);
  EXPECT_EQ(runner.reason(), "waiting for the tracker, 40 s: tracker: it restarted");
  EXPECT_EQ(runner.name(), "campaign");
  runner.await(CellDevice::Tracker, "tracker: it restarted");
  pass(80s);
  EXPECT_EQ(runner.name(), "paused");
  EXPECT_THAT(runner.reason(),
              testing::StartsWith("paused, waiting for the tracker, 120 s: tracker: it restarted; "
                                  "the campaign resumes by itself"));
  runner.await(CellDevice::Tracker, "");
  EXPECT_EQ(runner.name(), "campaign");
  EXPECT_EQ(runner.reason(), "the tracker answers");
  EXPECT_THAT(done, ElementsAre("pause", "resume"));
  const auto changes = event_data(control::Topic::Cell);
  ASSERT_EQ(changes.size(), 4U) << "started, lost, paused, back";
  EXPECT_EQ(
      control::json_text(changes[1]),
      R"({"state":"campaign","from":"campaign","reason":"waiting for the tracker, 0 s: tracker: it restarted","by":null})");
}

TEST_F(CellRunnerTest, TellsOfALossThatEndsBeforeTheCampaignPauses) {
  runner.apply(CampaignStartRequested{"c1"}, "asked for by an operator");
  runner.await(CellDevice::Controller, "robot: emergency stop");
  runner.await(CellDevice::Controller, "");
  runner.await(CellDevice::Controller, "");
  const auto changes = event_data(control::Topic::Cell);
  ASSERT_EQ(changes.size(), 3U);
  EXPECT_EQ(changes[2].at("reason"), "the controller answers");
  EXPECT_EQ(runner.reason(), "asked for by an operator");
}

TEST_F(CellRunnerTest, KeepsOneFaultOfACodeAndListsThemByIt) {
  ActiveFaults& faults = runner.faults();
  faults.stand(true, {FaultCode::Tracker, "gone"});
  faults.stand(true, {FaultCode::Tracker, "gone for longer"});
  faults.begin({FaultCode::Model, "refused"});
  EXPECT_EQ(faults.list().at(0).code, "E_MODEL");
  EXPECT_EQ(faults.text(FaultCode::Tracker), "gone");
  EXPECT_EQ(faults.text(FaultCode::Cell), "");
  faults.stand(false, {FaultCode::Tracker, ""});
  faults.end(FaultCode::Model);
  EXPECT_THAT(faults.list(), IsEmpty());
  EXPECT_EQ(event_data(control::Topic::Fault).size(), 4U);
}

TEST(FaultKinds, StandInTheTableOfThePage) {
  std::string page = config::read_text_file(std::filesystem::path{TRUEPOSE_SOURCE_DIR} / "docs/operate.md");
  std::erase(page, '`');
  std::string_view before;
  for (const FaultKind& kind : kFaultKinds) {
    EXPECT_LT(before, kind.code);
    before = kind.code;
    const std::string row = "\n| " + std::string{kind.code} + " | " + std::string{kind.meaning} + " | " +
                            std::string{kind.what_to_do};
    EXPECT_THAT(page, HasSubstr(row));
  }
}

}  // namespace
}  // namespace truepose::daemon
