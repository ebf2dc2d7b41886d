#include "daemon/cell/daemon_cell.hpp"

#include <gmock/gmock.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <functional>

#include "daemon/ethernet_file.hpp"
#include "drivers/mock/mock_robot.hpp"
#include "drivers/mock/mock_tracker.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "proto/control/json_text.hpp"
#include "tests/daemon/example_calibration.hpp"
#include "tests/daemon/example_cell.hpp"
#include "tests/daemon/stream_rig.hpp"
#include "tests/integration/sqlite_rows.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using namespace std::chrono_literals;

StreamOptions stream_in_virtual_time(const config::CellConfig& config) {
  StreamOptions options = StreamOptions::of(config);
  options.now = []() noexcept { return drivers::TimePoint{}; };
  return options;
}

/// A cell whose store holds the models of sound campaigns, m1 the active one.
struct DaemonCellTest : testing::Test {
  DaemonCellTest() {
    for (const char* number : {"2", "1"}) keep_calibration(number);
  }
  void keep_calibration(const std::string& number) {
    const auto result = std::make_shared<CampaignResult>(test::example_calibration(std::stoull(number)));
    StoreJournal journal{{.campaign_id = "c" + number, .model_id = "m" + number, .config = config},
                         *store,
                         store_thread,
                         wall_clock};
    ASSERT_TRUE(finish(journal.begin(result->identities)));
    for (const StoredPoint& point : result->points) ASSERT_TRUE(finish(journal.add_point(point)));
    ASSERT_TRUE(finish(journal.end(result, std::nullopt)));
  }
  template <typename T>
  T finish(asio::awaitable<T> work) {
    io.restart();
    std::optional<T> result;
    asio::co_spawn(io, std::move(work), [&](std::exception_ptr failed, T value) {
      EXPECT_FALSE(failed);
      result.emplace(std::move(value));
    });
    io.run();
    return *std::move(result);
  }
  /// What happens to the file behind the daemon's back.
  void execute(const std::string& sql) { sqlite_rows(file, sql.c_str()); }
  void load() { ASSERT_TRUE(finish(cell.load_active_model())); }
  std::expected<json::value, control::RpcError> call(const std::string& method, json::object params = {}) {
    return finish(cell.call(method, std::move(params)));
  }
  std::string refused(const std::string& method, json::object params = {}) {
    const auto answer = call(method, std::move(params));
    return answer ? "" : answer.error().message;
  }
  json::value status() { return call("cell.status").value(); }
  std::string fault() { return fault_of(status()); }
  static std::string fault_of(const json::value& now) {
    const json::array& faults = now.at("faults").as_array();
    return faults.empty() ? "" : std::string{faults.front().at("text").as_string().c_str()};
  }

  asio::io_context io;
  drivers::VirtualClock clock;
  config::CellConfig config = test::example_cell();
  drivers::MockCell mock{test::example_truth(), clock};
  drivers::MockRobot robot{mock};
  drivers::MockTracker tracker{mock};
  TempFolder folder;
  const std::filesystem::path file = folder.path() / "cell.sqlite";
  StoreResult<Store> store = Store::open(file);
  Worker store_thread, compute_thread;
  StoreJournal::WallClock wall_clock = [] { return std::chrono::system_clock::time_point{}; };
  EventBus events{{1, 1'000'000, [] {}}, wall_clock};
  std::unique_ptr<StreamCycle> stream =
      StreamCycle::create(config.robot.model, ethernet_config(), stream_in_virtual_time(config)).value();
  DaemonCell cell{{io.get_executor(), config, robot, tracker, clock, *stream, *store, store_thread,
                   compute_thread, events, wall_clock}};
};

TEST_F(DaemonCellTest, WorksWithTheModelThatItsStoreSaysIsActive) {
  load();
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
  EXPECT_THAT(fault(), IsEmpty());
  ASSERT_TRUE(call("model.activate", {{"id", "m2"}}));
  EXPECT_EQ(status().at_pointer("/model/id"), "m2");
}

TEST_F(DaemonCellTest, DoesNotWorkWithAModelOfWhichADigitHasBecomeAnother) {
  // Axis 1's zero, as a flipped bit or a person at the file may leave it.
  execute("UPDATE model SET yaml=replace(yaml, 'theta: 0.00', 'theta: 0.04') WHERE id='m1'");
  load();
  EXPECT_TRUE(status().at("model").is_null()) << control::json_text(status().at("model"));
  EXPECT_THAT(fault(), AllOf(HasSubstr("model m1 is refused"), HasSubstr("activate another model")));
  EXPECT_THAT(refused("stream.start"), HasSubstr("model m1 is refused"));
  EXPECT_THAT(refused("drift.check"), HasSubstr("model m1 is refused"));
  EXPECT_THAT(refused("targets.compensate", {{"joints", {{0, -90, 90, 0, 30, 0}}}}), HasSubstr("is refused"));

  ASSERT_TRUE(call("model.activate", {{"id", "m2"}}));
  EXPECT_EQ(status().at_pointer("/model/id"), "m2");
  EXPECT_THAT(fault(), IsEmpty()) << "another model is in force";
}

TEST_F(DaemonCellTest, DoesNotActivateAnAlteredModelAndKeepsTheOneInForce) {
  load();
  execute("UPDATE model SET yaml=replace(yaml, 'theta: 0.00', 'theta: 0.04'), sha256='' WHERE id='m2'");
  EXPECT_THAT(refused("model.activate", {{"id", "m2"}}), HasSubstr("misses its own validation points"));
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
  EXPECT_EQ(store->active_model().value()->id, "m1");
  EXPECT_THAT(fault(), IsEmpty());
}

TEST_F(DaemonCellTest, RefusesACampaignOfTooFewPosesBeforeTheArmMoves) {
  EXPECT_EQ(
      refused("campaign.start", {{"identify_poses", 8}}),
      "params.identify_poses: 8 are too few for the parameters of this arm: give at least 10, better twice "
      "as many");
  EXPECT_EQ(status().at("state"), "disconnected");
}

TEST_F(DaemonCellTest, ForgetsTheFaultOfAModelThatIsDeactivated) {
  execute("UPDATE model SET yaml=replace(yaml, 'theta: 0.00', 'theta: 0.04') WHERE id='m1'");
  load();
  EXPECT_THAT(fault(), HasSubstr("m1"));
  ASSERT_TRUE(call("model.deactivate"));
  EXPECT_THAT(fault(), IsEmpty());
}

/// A cell that is watched, beside a controller that sends every 4 ms until it falls silent.
struct AWatchedStream : DaemonCellTest {
  using Script = std::function<asio::awaitable<void>()>;

  AWatchedStream() {
    rig.cycle = std::move(stream);  // which the cell refers to
    execute("UPDATE model SET robot_serial='MOCK-0001', yaml=replace(yaml, 'S1', 'MOCK-0001'), sha256=''");
    load();
    sends = false;
    play([this]() -> asio::awaitable<void> {
      const auto connected = co_await ask("cell.connect");
      EXPECT_TRUE(connected);
    });
    sends = true;
  }
  asio::awaitable<std::expected<json::value, control::RpcError>> ask(const char* method) {
    auto asked = cell.call(method, json::object{});
    auto answer = co_await std::move(asked);
    co_return answer;
  }
  asio::awaitable<void> pass(drivers::Duration time) {
    const drivers::TimePoint then = clock.now() + time;
    co_await clock.sleep_until(then);
  }
  asio::awaitable<void> controller() {
    for (; !over; co_await pass(4ms)) {
      rig.set_time(clock.now());
      if (!sends) {
        if (read) rig.cycle->nothing_came(clock.now());
      } else {
        garbled ? garble() : static_cast<void>(rig.tick());
      }
    }
  }
  void garble() {
    rig.ipoc += rig.step;
    rig.send("<Rob Type=\"KUKA\"><IPOC>" + std::to_string(rig.ipoc) + "</IPOC></Rob>");
  }
  void play(Script script) {
    asio::cancellation_signal end;
    bool ended = false;
    over = false;
    asio::co_spawn(io, cell.watch(), asio::bind_cancellation_slot(end.slot(), asio::detached));
    asio::co_spawn(io, controller(), asio::detached);
    const auto act = [&]() -> asio::awaitable<void> {
      auto played = script();
      co_await std::move(played);
      over = true;
      end.emit(asio::cancellation_type::terminal);
      co_await pass(10ms);
      ended = true;
    };
    asio::co_spawn(io, act, asio::detached);
    EXPECT_TRUE(clock.run(io, [&] { return ended; }));
  }

  StreamRig rig;
  bool sends = true, garbled = false, over = false;
  bool read = true;  // by the realtime thread
};

TEST_F(AWatchedStream, IsAFaultHalfASecondAfterItsControllerFellSilent) {
  play([this]() -> asio::awaitable<void> {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started) << started.error().message;
    co_await pass(2s);
    auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "streaming");
    EXPECT_EQ(now->at_pointer("/stream/state"), "correcting") << control::json_text(now->at("stream"));
    sends = false;
    co_await pass(500ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "fault");
    EXPECT_NE(now->at_pointer("/stream/state"), "correcting");
    EXPECT_THAT(fault_of(*now), HasSubstr("has sent no RSI packet for 0."));
    EXPECT_EQ(now->at_pointer("/stream/reason").as_string(), fault_of(*now));
  });
}

TEST_F(AWatchedStream, DoesNotBlameTheControllerWhereThisMachineDoesNotRead) {
  play([this]() -> asio::awaitable<void> {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started) << started.error().message;
    co_await pass(2s);
    sends = read = false;
    co_await pass(1s);
    auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "streaming");
    EXPECT_EQ(now->at_pointer("/stream/state"), "waiting") << "nothing is corrected";
    EXPECT_THAT(std::string{now->at_pointer("/stream/reason").as_string()},
                HasSubstr("this PC has not run truepose's RSI thread for 1.0 s"));
    read = true;
    co_await pass(100ms);
    now = co_await ask("cell.status");
    EXPECT_THAT(fault_of(*now), HasSubstr("the controller has sent no RSI packet for 1."));
  });
}

TEST_F(AWatchedStream, SaysWhatToLookAtWhereNoPacketComes) {
  sends = false;
  play([this]() -> asio::awaitable<void> {
    const drivers::TimePoint asked = clock.now();
    const auto started = co_await ask("stream.start");
    EXPECT_FALSE(started);
    EXPECT_LE(clock.now() - asked, 5s);
    EXPECT_THAT(started.error().message,
                AllOf(HasSubstr("no packet came to"), HasSubstr("IP_NUMBER and PORT"), HasSubstr("RSI_ON")));
  });
}

TEST_F(AWatchedStream, DoesNotStartOnPacketsThatItCannotReadAndSaysWhy) {
  garbled = true;
  play([this]() -> asio::awaitable<void> {
    const auto started = co_await ask("stream.start");
    EXPECT_FALSE(started);
    EXPECT_THAT(started.error().message, AllOf(HasSubstr("none was understood"),
                                               HasSubstr("ASPos is missing"), HasSubstr("127.0.0.1:40000")));
  });
}

TEST_F(AWatchedStream, SaysWhatIsWrongWithTheControllersPacketsWhileItStillWaitsForGoodOnes) {
  garbled = true;
  play([this]() -> asio::awaitable<void> {
    bool started = false;
    asio::co_spawn(
        io,
        [&]() -> asio::awaitable<void> {
          EXPECT_FALSE(co_await ask("stream.start"));
          started = true;
        },
        asio::detached);
    co_await pass(2s);
    auto now = co_await ask("stream.status");
    EXPECT_EQ(now->at("state"), "waiting");
    EXPECT_THAT(now->at("reason").as_string().c_str(),
                AllOf(HasSubstr("none was understood"), HasSubstr("ASPos is missing"),
                      HasSubstr(config.stream.ethernet_xml)));
    while (!started) co_await pass(100ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/stream/state"), "off");
    EXPECT_EQ(now->at_pointer("/stream/reason").as_string(), fault_of(*now));
  });
}

TEST_F(AWatchedStream, TellsThatTheRobotIsGoneWhileItStreams) {
  play([this]() -> asio::awaitable<void> {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started);
    robot.disconnect();
    co_await pass(2s);
    const auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "fault");
    EXPECT_EQ(now->at_pointer("/robot/connected"), false);
  });
}

TEST_F(AWatchedStream, GoesOnWithoutItsTrackerAndSaysSo) {
  play([this]() -> asio::awaitable<void> {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started);
    tracker.disconnect();
    co_await pass(7s);
    const auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/stream/state"), "correcting") << control::json_text(now->at("stream"));
    EXPECT_EQ(now->at_pointer("/tracker/connected"), false);
    EXPECT_THAT(fault_of(*now), HasSubstr("the stream goes on without it"));
  });
}

TEST(StreamJson, SaysCorrectingOfAStreamThatHasAModelAlone) {
  const auto told = [](std::uint64_t model, double a1_deg) {
    StreamStatus status;
    status.state = StreamState::Active;
    status.model = model;
    status.correction_deg[0] = a1_deg;
    return stream_json(
        status, {},
        {.streaming = true, .age = drivers::Duration{0}, .refused = "", .trouble = "", .model_id = ""});
  };
  EXPECT_EQ(told(1, 0.5).at("state"), "correcting");
  EXPECT_EQ(told(0, 0.5).at("state"), "ramping") << "out of the model that was in force";
  EXPECT_EQ(told(0, 0).at("state"), "waiting");
  EXPECT_THAT(std::string{told(0, 0).at("reason").as_string().c_str()}, HasSubstr("no model is active"));
}

}  // namespace
}  // namespace truepose::daemon
