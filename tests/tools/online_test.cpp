#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>

#include "daemon/control/control_server.hpp"
#include "drivers/clock.hpp"
#include "proto/record/json_io.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/fake_cell.hpp"
#include "tests/tools/terminal.hpp"
#include "tools/truepose/online/campaign_watch.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/rpc_client.hpp"

namespace truepose::tools {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
namespace json = boost::json;
using testing::HasSubstr;

struct Outcome {
  int exit_code;
  std::string out, err;
};

class OnlineTest : public testing::Test {
 protected:
  OnlineTest() {
    write_token("token", "0123456789abcdef");
    fs::create_directory(socket().parent_path());
    on_loop([this] {
      server_ = daemon::ControlServer::start(io_.get_executor(),
                                             {clock_, [] { return std::chrono::system_clock::time_point{}; },
                                              cell_, events_, [](const std::string&) {}, worker_, socket()},
                                             {{"127.0.0.1", 0}, folder_.path() / "token"}, "cell 1")
                    .value();
      server_->serve();
      address_ = "127.0.0.1:" + std::to_string(server_->port());
    });
  }
  ~OnlineTest() override {
    on_loop([this] { server_.reset(); });
    work_.reset();
    thread_.join();
  }
  fs::path socket() const { return folder_.path() / "truepose-test/control.sock"; }
  void write_token(const char* file, const char* token) {
    std::ofstream{folder_.path() / file} << token << '\n';
    fs::permissions(folder_.path() / file, fs::perms::owner_read | fs::perms::owner_write);
  }
  void on_loop(const std::function<void()>& task) {
    std::promise<void> done;
    asio::post(io_, [&] {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }
  /// Runs a command line as main() does.
  Outcome run(std::vector<std::string> words, const std::string& token_file = "token",
              std::string address = {}) {
    words.insert(words.end(), {"--daemon", address.empty() ? address_ : address, "--token-file",
                               folder_.path() / token_file});
    return run_all(std::move(words));
  }

  Outcome run_all(std::vector<std::string> words) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int exit_code = run_command_line(online_commands(), std::move(words));
    return {exit_code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
  }

  TempFolder folder_;
  daemon::EventBus events_{{.first = 1, .end = 1'000'000, .request_more = {}},
                           [] { return std::chrono::system_clock::time_point{}; }};
  drivers::SteadyClock clock_;
  FakeCell cell_{events_};
  daemon::Worker worker_;
  asio::io_context io_;
  asio::executor_work_guard<asio::io_context::executor_type> work_{io_.get_executor()};
  std::unique_ptr<daemon::ControlServer> server_;
  std::string address_;
  std::thread thread_{[this] { io_.run(); }};
};

TEST_F(OnlineTest, StatusIsAReadableTable) {
  const Outcome status = run({"status"});
  EXPECT_EQ(status.exit_code, 0) << status.err;
  EXPECT_EQ(status.out,
            "cell       cell 1\n"
            "state      ready: waits for a command\n"
            "next       Start a campaign.\n"
            "robot      #KR210, serial 42, not ready: drives off\n"
            "tracker    not connected\n"
            "model      none active\n"
            "stream     off\n"
            "recording  the last 61 s, 2 kB, dropped 0\n"
            "warning    E_BEAM: beam broken (since s)\n");
}

TEST_F(OnlineTest, TheDaemonMayBeNamedBeforeTheCommandToo) {
  const Outcome outcome = run_all({"--daemon", address_, "--token-file", folder_.path() / "token", "status"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(OnlineTest, AnAnswerOfAnotherFormIsAnErrorThatNamesItAndStillJson) {
  for (const auto& [answer, why] : {std::pair{"null", "expected an object, found null"},
                                    {"3", "expected an object, found 3"},
                                    {"[]", "expected an object, found []"},
                                    {"{}", "missing key 'models'"},
                                    {R"({"models":[],"total":"no"})", "total: expected a whole number of 0"},
                                    {R"({"models":[null],"total":1})", "models[0]: expected an object"},
                                    {R"({"models":[{}],"total":1})", "models[0]: missing key 'id'"}}) {
    cell_.answers["model.list"] = json::parse(answer);
    const Outcome outcome = run({"model", "list"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err,
                HasSubstr("model.list: the daemon's answer cannot be read: " + std::string{why}));
    EXPECT_EQ(json::parse(run({"model", "list", "--json"}).out), cell_.answers["model.list"]);
  }
  cell_.answers["model.list"] = json::parse(R"({"models":[],"total":0,"of a newer daemon":1})");
  EXPECT_EQ(run({"model", "list"}).out, "no models yet\n");
}

TEST_F(OnlineTest, WatchShowsProgressUntilTheCampaignEnds) {
  const Outcome watched = run({"campaign", "start", "--watch"});
  EXPECT_EQ(watched.exit_code, 0) << watched.err;
  EXPECT_EQ(watched.out,
            "identifying  3/60 poses\n"
            "validating   31/60 poses  error 0.043 mm  1 min 20 s left\n"
            "00:00:00  the tracker answers\n"
            "00:00:00  pose 12, attempt 1 of 3: tracker: the beam was broken\n"
            "done         60/60 poses, 1 skipped  error 0.043 mm  1 min 20 s left\n"
            "campaign c1 is done: model m1, 0.042 mm on validation poses, active\n"
            "next: truepose report c1 --html report.html\n");
  cell_.final_phase = "failed";
  const Outcome failed = run({"campaign", "watch", "c1"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.out,
              HasSubstr("campaign c1 failed; what it measured is kept\nnext: truepose campaign show c1\n"));
}

TEST_F(OnlineTest, WatchNamesTheCommandThatACampaignWasFor) {
  const auto next = [this](const char* kind) {
    cell_.kind = kind;
    const std::string out = run({"campaign", "watch", "c1"}).out;
    return out.substr(out.find("campaign c1 is done"));
  };
  EXPECT_EQ(next("tool"), "campaign c1 is done\nnext: truepose tools activate c1\n");
  EXPECT_EQ(next("base"), "campaign c1 is done\nnext: truepose campaign export c1 --frame base.yaml\n");
  EXPECT_EQ(next("drift"), "campaign c1 is done\nnext: truepose campaign show c1\n");
}

TEST_F(OnlineTest, StartSendsWhatWasAskedForOnly) {
  const auto start = [this](std::vector<std::string> words) {
    words.insert(words.begin(), {"campaign", "start"});
    return run(std::move(words));
  };
  const auto asked = [&](std::vector<std::string> words) {
    words.push_back("--json");
    return json::parse(start(std::move(words)).out).at("asked");
  };
  EXPECT_EQ(asked({}), json::object{});
  EXPECT_EQ(asked({"--identify", "25", "--no-remeasure", "--no-activate"}),
            json::parse(R"({"identify_poses":25,"remeasure":false,"activate":false})"));
  EXPECT_EQ(asked({"--tool", "3", "--points", "a,b", "--at", "1,2,3,4,5,6", "--facing", "0,0,1",
                   "--tool-poses", "8", "--together"}),
            json::parse(R"({"points":["a","b"],"together":true,"kind":"tool",
            "number":3,"poses_per_point":8,"at":[[1.0,2.0,3.0],[4.0,5.0,6.0]],"facing":[[0.0,0.0,1.0]]})"));
  const std::string points =
      folder_.write("points.csv", "point,x,y,z,px,py,pz\na,1,2,3,0,0,0\nb,4,5,6,0,0,9\n");
  EXPECT_EQ(asked({"--base", "5", "--points-file", points}),
            json::parse(R"({"kind":"base","number":5,"points":["a","b"],"at":[[1.0,2.0,3.0],[4.0,5.0,6.0]],
            "nominal":[[0.0,0.0,0.0],[0.0,0.0,9.0]]})"));
  EXPECT_EQ(asked({"--base", "5", "--touch", "3", "--points", "origin,x,xy", "--readings", "2"}),
            json::parse(R"({"kind":"base","number":5,"touch":3,"points":["origin","x","xy"],"readings":2})"));
  const std::string known = folder_.write("known.csv", "point,px,py,pz\na,0,0,0\nb,0,0,9\n");
  EXPECT_EQ(asked({"--base", "5", "--touch", "3", "--points-file", known}),
            json::parse(R"({"kind":"base","number":5,"touch":3,"points":["a","b"],
            "nominal":[[0.0,0.0,0.0],[0.0,0.0,9.0]]})"));
  EXPECT_THAT(start({"--base", "5", "--touch", "3", "--points-file", points}).err,
              HasSubstr("points.csv: the columns x,y,z are for the tracker, and --touch does without"));
  EXPECT_THAT(start({"--touch", "3", "--points", "origin,x,xy"}).err, HasSubstr("--base"));
  EXPECT_THAT(start({"--tool", "3", "--at", "1,2"}).err,
              HasSubstr("--at: expected three numbers for each point"));
}

TEST_F(OnlineTest, StartSendsTheTargetsOfAFile) {
  const auto start = [this](const std::string& text) {
    return run({"campaign", "start", "--kind", "targets", "--targets", folder_.write("targets.csv", text),
                "--json"});
  };
  EXPECT_EQ(json::parse(start("q1,q2,residual_mm\n10,20,0.1\n30,40,0.1\n").out).at("asked"),
            json::parse(R"({"kind":"targets","joints":[[10.0,20.0],[30.0,40.0]]})"));
  EXPECT_EQ(json::parse(start("x,y,z,a,b,c\n1,2,3,4,5,6\n").out).at("asked"),
            json::parse(R"({"kind":"targets","poses":[[1.0,2.0,3.0,4.0,5.0,6.0]]})"));
  const Outcome branched = start("x,y,z,a,b,c,s,t\n1,2,3,4,5,6,2,43\n");
  EXPECT_EQ(branched.exit_code, 2);
  EXPECT_THAT(branched.err, HasSubstr("targets.csv: columns s and t: here the branch is the one nearest"));
}

TEST_F(OnlineTest, EventsThatDoNotComeEndTheCommandAfterItsTimeout) {
  const Outcome none = run({"events", "--count", "1", "--timeout", "0.1"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_EQ(none.err, "truepose: events: none within 0.1 s\n");
  EXPECT_EQ(none.out, "");
}

TEST_F(OnlineTest, EventsAreOneLineEach) {
  events_.publish(control::Topic::Log, json::object{{"level", "info"}, {"text", "hello"}});
  events_.publish(control::Topic::Cell,
                  json::object{{"from", "ready"}, {"state", "fault"}, {"reason", "beam"}});
  EXPECT_EQ(run({"events", "--after", "0", "--count", "2"}).out,
            "1  1970-01-01T00:00:00.000Z  log  info: hello\n"
            "2  1970-01-01T00:00:00.000Z  cell  ready -> fault: beam\n");
  const Outcome cells = run({"events", "--after", "0", "--count", "1", "--topics", "fault,cell", "--json"});
  EXPECT_EQ(json::parse(cells.out).at("seq").as_int64(), 2);
}

TEST_F(OnlineTest, AnEventOfAnotherFormIsPrintedAsItIs) {
  events_.publish(control::Topic::Cell, json::object{{"state", "asleep"}});
  EXPECT_THAT(run({"events", "--after", "0", "--count", "1"}).out, HasSubstr(R"(cell  {"state":"asleep"})"));
}

TEST_F(OnlineTest, EventsTellPointsSeenTouchedAndSkippedApart) {
  json::object data{{"campaign_id", "c1"}, {"pose", 4},         {"purpose", "frame"},  {"smr", "xy"},
                    {"p_mm", nullptr},     {"std_mm", nullptr}, {"error_mm", nullptr}, {"reason", ""}};
  events_.publish(control::Topic::Measurement, data);
  data["reason"] = "the beam was broken";
  events_.publish(control::Topic::Measurement, data);
  EXPECT_THAT(run({"events", "--after", "0", "--count", "2"}).out,
              testing::AllOf(HasSubstr("frame pose 4: touched xy\n"),
                             HasSubstr("frame pose 4: skipped, the beam was broken\n")));
}

TEST_F(OnlineTest, ExitCodesTellWhatWentWrong) {
  const Outcome device = run({"connect"});
  EXPECT_EQ(device.exit_code, 3);
  EXPECT_EQ(device.err, "truepose: connect: the tracker does not answer\n");
  const Outcome state = run({"campaign", "pause"});
  EXPECT_EQ(state.exit_code, 1);
  EXPECT_EQ(state.err,
            "truepose: campaign pause: no campaign runs (state ready). Possible: truepose campaign start\n");
  const json::value as_json = json::parse(run({"campaign", "pause", "--json"}).err).at("error");
  EXPECT_EQ(as_json.at("code"), -32003);
  EXPECT_EQ(as_json.at("exit_code"), 1);
  write_token("wrong", "fedcba9876543210");
  const Outcome token = run({"status"}, "wrong");
  EXPECT_EQ(token.exit_code, 2);
  EXPECT_EQ(json::parse(run({"status", "--json"}, "wrong").err).at_pointer("/error/code"), -32001);
  EXPECT_EQ(run({"status"}, "missing").exit_code, 2);
  EXPECT_EQ(run({"status"}, "token", "nonsense").exit_code, 2);
}

TEST_F(OnlineTest, IdsAreCompletedFromTheirStartAndFromLatest) {
  const std::string a = "11df5da4-0000-4000-8000-000000000001", b = "11df9999-0000-4000-8000-000000000002",
                    c = "c0ffee00-0000-4000-8000-000000000003";
  cell_.answers["campaign.list"] = record::to_json(FakeCell::campaigns({c, b, a}));
  const auto asked = [this](const std::string& word) {
    cell_.asked_id.clear();
    const Outcome outcome = run({"campaign", "show", word});
    return outcome.exit_code == 0 ? cell_.asked_id : std::to_string(outcome.exit_code) + " " + outcome.err;
  };
  EXPECT_EQ(asked("11df5"), a);
  EXPECT_EQ(asked("latest"), c);
  EXPECT_EQ(asked(b), b);
  EXPECT_EQ(asked("77"),
            "1 truepose: no campaign has an id that begins with '77'. See truepose campaign list\n");
  EXPECT_EQ(asked("11df"), "2 truepose: the ids of 2 campaigns begin with '11df': " + b +
                               " (calibration, 2026-01-31T12:00:00.000Z); " + a +
                               " (calibration, 2026-01-31T12:00:00.000Z). Give more of it\n");
  cell_.answers["campaign.list"] = record::to_json(FakeCell::campaigns({}));
  EXPECT_EQ(asked("latest"), "1 truepose: there is no campaign yet\n");
}

TEST_F(OnlineTest, AShellIsOfferedTheIdsOfTheDaemon) {
  ::setenv("TRUEPOSE_DAEMON", address_.c_str(), 1);
  ::setenv("TRUEPOSE_TOKEN_FILE", (folder_.path() / "token").c_str(), 1);
  EXPECT_THAT(run_all({"__complete", "campaign", "show", ""}).out,
              HasSubstr("latest\tcampaign\nc1\tcampaign\n"));
  ::unsetenv("TRUEPOSE_TOKEN_FILE");
  ::unsetenv("TRUEPOSE_DAEMON");
}

TEST_F(OnlineTest, ATerminalShowsShortIdsAndLocalTimesWithinItsWidth) {
  const std::vector<std::string> words{"campaign", "list",         "--daemon",
                                       address_,   "--token-file", folder_.path() / "token"};
  cell_.answers["campaign.list"] = record::to_json(
      FakeCell::campaigns({"11df5da4-0000-4000-8000-000000000001", "c0ffee00-0000-4000-8000-000000000003"}));
  std::string shown;
  {
    Terminal terminal;
    EXPECT_EQ(run_command_line(online_commands(), words), 0);
    shown = terminal.text();
  }
  EXPECT_EQ(shown,
            "CAMPAIGN  KIND         STARTED              STATE  ROBOT  MODEL\n"
            "11df5da4  calibration  2026-01-31 13:00:00  done   -      11df5da4\n"
            "c0ffee00  calibration  2026-01-31 13:00:00  done   -      c0ffee00\n");
  {
    Terminal terminal;
    std::vector<std::string> verbose = words;
    verbose.push_back("-v");
    EXPECT_EQ(run_command_line(online_commands(), verbose), 0);
    shown = terminal.text();
  }
  EXPECT_THAT(shown, HasSubstr("11df5da4-0000-4000-8000-000000000001"));
  EXPECT_THAT(run({"campaign", "list"}).out, HasSubstr("2026-01-31T12:00:00.000Z"));
}

TEST_F(OnlineTest, SaysWhatAnAddressOfTheDaemonLooksLike) {
  const Outcome outcome = run({"status"}, "token", "localhost:none");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--daemon: expected a port of 1..65535, found 'none'"));
}

TEST_F(OnlineTest, AControlSocketNeedsNoToken) {
  const Outcome outcome = run_all({"status", "--daemon", socket()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(OnlineTest, AControlSocketInAFolderOfEverybodyIsNotBelieved) {
  fs::permissions(socket().parent_path(), fs::perms{0777});
  const Outcome outcome = run_all({"status", "--daemon", socket()});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("others may write to its folder"));
}

TEST_F(OnlineTest, ControlSocketsAreFoundInTheUsersFolderAndInTheSystems) {
  fs::create_directories(folder_.path() / "system/press");
  const asio::local::stream_protocol::acceptor other{io_, {folder_.path() / "system/press/control.sock"}};
  EXPECT_THAT(control_sockets(folder_.path(), folder_.path() / "system"),
              testing::ElementsAre(socket(), folder_.path() / "system/press/control.sock"));
  EXPECT_THAT(control_sockets({}, folder_.path() / "none"), testing::IsEmpty());
}

/// A server at a daemon's port that answers as a daemon would, and records its requests.
class Squatter {
 public:
  std::string address() const { return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()); }
  std::string heard() {
    thread_.join();
    return heard_;
  }

 private:
  void serve() {
    asio::ip::tcp::socket client = acceptor_.accept();
    for (const char* result : {R"({"nonce": "00112233445566778899aabbccddeeff"})",
                               R"({"product": "trueposed", "protocol": 1, "proof": "00"})"}) {
      std::string line;
      asio::read_until(client, asio::dynamic_buffer(line), '\n');
      heard_ += line;
      const std::string id = std::to_string(json::parse(line).at("id").as_int64());
      asio::write(client,
                  asio::buffer(R"({"jsonrpc": "2.0", "id": )" + id + R"(, "result": )" + result + "}\n"));
    }
  }

  asio::io_context context_;
  asio::ip::tcp::acceptor acceptor_{context_, {asio::ip::address_v4::loopback(), 0}};
  std::string heard_;
  std::thread thread_{[this] { serve(); }};
};

TEST_F(OnlineTest, WhoeverSquatsOnTheDaemonsPortIsNotTakenForItAndLearnsNoToken) {
  Squatter squatter;
  const Outcome outcome = run({"status"}, "token", squatter.address());
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("does not know the token"));
  const std::string heard = squatter.heard();
  EXPECT_THAT(heard, HasSubstr("session.hello"));
  EXPECT_THAT(heard, testing::Not(HasSubstr("0123456789abcdef")));
}

TEST_F(OnlineTest, ADaemonThatStopsEndsAWatchWithItsReason) {
  auto client = RpcClient::connect({address_, folder_.path() / "token"});
  ASSERT_TRUE(client);
  on_loop([this] { server_->stop(); });
  try {
    watch_to_end(*client, {.id = "c1", .phase = "identifying"}, true);
    FAIL() << "it has ended well";
  } catch (const CommandError& error) {
    EXPECT_EQ(error.exit_code, kUnreachable);
    EXPECT_THAT(error.message, testing::AllOf(HasSubstr("is lost"), HasSubstr("truepose status has")));
  }
}

}  // namespace
}  // namespace truepose::tools
