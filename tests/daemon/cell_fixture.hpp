#pragma once

#include <gmock/gmock.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/sealed_text.hpp"
#include "daemon/cell/daemon_cell.hpp"
#include "drivers/mock/mock_robot.hpp"
#include "drivers/mock/mock_tracker.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/request.hpp"
#include "proto/control/schema.hpp"
#include "proto/text/digest.hpp"
#include "tests/daemon/example_calibration.hpp"
#include "tests/daemon/example_cell.hpp"
#include "tests/daemon/stream_rig.hpp"
#include "tests/integration/sqlite_rows.hpp"
#include "tests/schema_check.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {

/// Does its jobs in place, so that virtual time stands still meanwhile.
struct InPlaceWorker final : Worker {
  boost::asio::awaitable<void> run(std::function<void()> job) override {
    if (before_each_job) before_each_job();
    job();
    if (after_each_job) after_each_job();
    co_return;
  }
  std::function<void()> before_each_job;
  std::function<void()> after_each_job;
};

/// A cell over mock devices in virtual time, without a socket. Its store holds the models of sound campaigns
/// of the mock arm: m1, the active one, and m2.
struct CellTest : testing::Test {
  static constexpr const char* kOperator = "Anna";
  using Answer = std::expected<boost::json::value, control::RpcError>;
  using Wait = boost::asio::awaitable<void>;

  CellTest() {
    for (const std::uint64_t number : {2U, 1U}) keep_calibration(number);
  }
  void TearDown() override {
    for (const auto& topic : control::kTopics) {
      for (const boost::json::value& data : event_data(topic.value))
        EXPECT_THAT(promises().of_event(std::string{topic.name}, data), testing::IsEmpty()) << topic.name;
    }
  }
  static const SchemaCheck& promises() {
    static const boost::json::value document = control::parse_json(control::openrpc_text()).value();
    static const SchemaCheck check{document};
    return check;
  }
  /// Whatever is asked in a test, the answer is one that openrpc.json tells of.
  static Answer as_promised(const std::string& method, Answer answer) {
    if (answer) {
      EXPECT_THAT(promises().of_result(method, *answer), testing::IsEmpty()) << method;
    }
    return answer;
  }
  void keep_calibration(std::uint64_t number) {
    static std::map<std::uint64_t, std::shared_ptr<const CampaignResult>> made;
    std::shared_ptr<const CampaignResult>& result = made[number];
    if (!result) {
      CampaignResult calibration = test::example_calibration(number);
      calibration.identities = {{"#KR210R2700_2 C4 FLR", "MOCK-0001", "KSS"}, {"MockTracker", "T1", "1"}};
      result = std::make_shared<const CampaignResult>(std::move(calibration));
    }
    const std::string digits = std::to_string(number);
    StoreJournal journal{{.campaign_id = "c" + digits, .model_id = "m" + digits, .config = config},
                         *store,
                         store_thread,
                         wall_clock,
                         clock};
    EXPECT_TRUE(finish(journal.begin(0)));
    EXPECT_TRUE(finish(journal.know(result->identities)));
    for (const StoredPoint& point : result->points) EXPECT_TRUE(finish(journal.add_point(point)));
    EXPECT_TRUE(finish(journal.end(result, std::nullopt)));
  }
  template <typename T>
  T finish(boost::asio::awaitable<T> work) {
    std::optional<T> result;
    boost::asio::co_spawn(io, std::move(work), [&](std::exception_ptr failed, T value) {
      EXPECT_FALSE(failed);
      result.emplace(std::move(value));
    });
    EXPECT_TRUE(clock.run(io, [&] { return result.has_value(); }));
    return *std::move(result);
  }
  /// What happens to the store's file behind the daemon's back.
  void execute(const std::string& sql) const { sqlite_rows(file, sql.c_str()); }
  /// Gives the altered texts of models hashes that fit.
  void seal_again() const {
    for (const auto& row : sqlite_rows(file, "SELECT id, yaml FROM model")) {
      const std::string yaml = config::sealed(row[1].substr(0, row[1].find("sha256: ")));
      execute("UPDATE model SET yaml='" + quoted(yaml) + "', sha256='" + text::sha256_hex(yaml) +
              "' WHERE id='" + row[0] + "'");
    }
  }
  static std::string quoted(std::string text) {
    for (std::size_t at = 0; (at = text.find('\'', at)) != std::string::npos; at += 2)
      text.insert(at, 1, '\'');
    return text;
  }
  void alter_m1() const {
    // Axis 1's zero, as a flipped bit or a person at the file may leave it.
    execute("UPDATE model SET yaml=replace(yaml, 'theta: 0.00', 'theta: 0.04') WHERE id='m1'");
  }
  void load() { EXPECT_TRUE(finish(cell.load_active_model())); }

  Answer call(const std::string& method, boost::json::object params = {}) {
    return as_promised(method, finish(cell.call(method, std::move(params), kOperator)));
  }
  std::string refused(const std::string& method, boost::json::object params = {}) {
    const Answer answer = call(method, std::move(params));
    return answer ? "" : answer.error().message;
  }
  boost::json::value status() { return call("cell.status").value(); }
  std::string fault() { return fault_of(status()); }
  static std::string fault_of(const boost::json::value& status) {
    const boost::json::array& faults = status.at("faults").as_array();
    return faults.empty() ? "" : std::string{faults.front().at("text").as_string()};
  }
  /// Data of the events on a topic, oldest first.
  std::vector<boost::json::value> event_data(control::Topic topic) {
    std::vector<boost::json::value> data;
    const auto reader = events.subscribe({topic}, 0, [] {});
    for (const EventBus::Line& line : reader->take(EventBus::kKept).lines)
      data.push_back(std::get<control::Event>(control::decode_server_line(*line).value()).data);
    return data;
  }

  // Within a script, which is a coroutine.

  boost::asio::awaitable<Answer> ask(std::string method, boost::json::object params = {}) {
    auto asked = cell.call(method, std::move(params), kOperator);
    auto answer = co_await std::move(asked);
    co_return as_promised(method, std::move(answer));
  }
  Wait pass(drivers::Duration time) {
    const drivers::TimePoint then = clock.now() + time;
    co_await clock.sleep_until(then);
  }
  Wait connected() {
    const Answer answer = co_await ask("cell.connect");
    EXPECT_TRUE(answer) << answer.error().message;
  }
  /// Asks, and does not wait for the answer.
  void send(std::string method, boost::json::object params = {}) {
    boost::asio::co_spawn(io, ask(std::move(method), std::move(params)), boost::asio::detached);
  }
  Wait campaign_ended() {
    for (auto now = co_await ask("cell.status"); !now->at("campaign").is_null();
         now = co_await ask("cell.status"))
      co_await pass(std::chrono::seconds{1});
  }

  /// What runs concurrently with the script.
  virtual Wait surroundings() { co_return; }
  /// Runs the script concurrently with the watches of the cell.
  void play(std::function<Wait()> script) {
    boost::asio::cancellation_signal end;
    bool ended = false;
    over = false;
    boost::asio::co_spawn(io, cell.watch(),
                          boost::asio::bind_cancellation_slot(end.slot(), boost::asio::detached));
    boost::asio::co_spawn(io, surroundings(), boost::asio::detached);
    const auto act = [&]() -> Wait {
      auto played = script();
      co_await std::move(played);
      over = true;
      end.emit(boost::asio::cancellation_type::terminal);
      co_await pass(std::chrono::milliseconds{10});
    };
    boost::asio::co_spawn(io, act, [&](std::exception_ptr failed) {
      ended = true;
      if (failed) std::rethrow_exception(failed);
    });
    EXPECT_TRUE(clock.run(io, [&] { return ended; }));
  }

  bool over = false;  ///< the script has ended
  boost::asio::io_context io;
  drivers::VirtualClock clock;
  TempFolder folder;
  config::CellConfig config = config_in(folder.path());
  drivers::MockCellOptions truth = test::example_truth();
  drivers::MockCell mock{truth, clock};
  drivers::MockRobot robot{mock};
  drivers::MockTracker tracker{mock};
  const std::filesystem::path file = folder.path() / "cell.sqlite";
  StoreResult<Store> store = Store::open(file);
  InPlaceWorker store_thread, compute_thread;
  std::chrono::seconds set_ahead{0};  ///< of the wall clock, as somebody may set it meanwhile
  drivers::WallClock wall_clock = [this] {
    return std::chrono::system_clock::time_point{
        std::chrono::duration_cast<std::chrono::system_clock::duration>(clock.now().time_since_epoch()) +
        set_ahead};
  };
  EventBus events{{1, 1'000'000, [] {}}, wall_clock};
  static StreamOptions stream_options_of(const config::CellConfig& config) {
    StreamOptions options = StreamOptions::of(config);
    options.peer = 0x7f000001;
    return options;
  }
  static config::CellConfig config_in(const std::filesystem::path& folder) {
    config::CellConfig config = test::example_cell();
    config.recording.folder = folder;
    return config;
  }
  std::unique_ptr<StreamCycle> stream =
      StreamCycle::create(config.robot.model, ethernet_config(), stream_options_of(config)).value();
  Recorder recorder{Ring::in_process(Ring::kLeastBytes), clock};
  InPlaceWorker recorder_thread;
  DaemonCell cell{{io.get_executor(), config, robot, tracker, clock, *stream, *store, store_thread,
                   compute_thread, events, recorder, recorder_thread, wall_clock}};
};

}  // namespace truepose::daemon
