#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/json/parse.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <thread>

#include "tests/integration/live_cell.hpp"

// A daemon is recorded while the simulated cell misbehaves. With TRUEPOSE_RECORDINGS=FOLDER every
// misbehaviour is, and the recordings are kept there: those of tests/recordings, which other tests replay,
// were made so.

namespace truepose {
namespace {

namespace json = boost::json;

/// What is recorded.
enum class Scene { Stream, Campaign };

struct Recorded {
  const char* name;
  Scene scene;
  const char* faults;
  int cycles = 300;       ///< of a stream
  const char* then = "";  ///< what befalls it after half of them, for the simulator's admin port
};

constexpr std::array kRecorded{
    Recorded{"rsi-lose-replies", Scene::Stream,
             "[{kind: rsi-lose-replies, at_cycle: 150, lasts_cycles: 20, every_cycles: 50}]"},
    Recorded{"rsi-drop", Scene::Stream, "[{kind: rsi-drop, at_cycle: 150, lasts_cycles: 30}]"},
    Recorded{"rsi-lose-datagrams", Scene::Stream,
             "[{kind: rsi-lose-datagrams, at_cycle: 150, lasts_cycles: 5, every_cycles: 50}]"},
    Recorded{"rsi-duplicate", Scene::Stream, "[{kind: rsi-duplicate, at_cycle: 150, lasts_cycles: 50}]"},
    Recorded{"rsi-reorder", Scene::Stream, "[{kind: rsi-reorder, at_cycle: 150, lasts_cycles: 50}]"},
    Recorded{"rsi-silence", Scene::Stream, "[{kind: rsi-silence, at_cycle: 150, lasts_cycles: 100000}]"},
    Recorded{"rsi-restart", Scene::Stream, "[{kind: rsi-restart, at_cycle: 150}]"},
    Recorded{"rsi-ipoc", Scene::Stream, "[{kind: rsi-ipoc, at_cycle: 150, ipoc_by: 1000}]"},
    Recorded{"rsi-ignore", Scene::Stream, "[{kind: rsi-ignore, at_cycle: 2}]", 700},
    Recorded{"rsi-second-sender", Scene::Stream,
             "[{kind: rsi-second-sender, at_cycle: 150, lasts_cycles: 50, from: 127.0.0.2}]"},
    Recorded{"program-stop", Scene::Stream, "[]", 220, R"({"kind": "program-stop", "lasts_ms": 200000})"},
    Recorded{"emergency-stop", Scene::Stream, "[]", 220, R"({"kind": "emergency-stop"})"},
    Recorded{"controller-restart", Scene::Stream, "[]", 220,
             R"({"kind": "controller-restart", "lasts_ms": 200000})"},
    Recorded{"eki-drop", Scene::Campaign, "[{kind: eki-drop, at_ms: 60000, every_ms: 150000}]"},
    Recorded{"beam-break", Scene::Campaign,
             "[{kind: beam-break, at_ms: 100000, lasts_ms: 4000, every_ms: 40000}]"},
    Recorded{"tracker-restart", Scene::Campaign, "[{kind: tracker-restart, at_ms: 60000, every_ms: 150000}]"},
    Recorded{"tracker-bump", Scene::Campaign,
             "[{kind: tracker-bump, at_point: 4, by_mm: {x: 3, y: 0, z: 4}}]"},
    Recorded{"tracker-bias", Scene::Campaign,
             "[{kind: tracker-bias, at_point: 4, by_mm: {x: 3, y: 0, z: 4}}]"},
    Recorded{"tracker-noise", Scene::Campaign,
             "[{kind: tracker-noise, at_point: 4, lasts_points: 2, sigma_mm: 1}]"},
    Recorded{"tracker-std", Scene::Campaign,
             "[{kind: tracker-std, at_point: 4, lasts_points: 2, std_mm: 5}]"},
    Recorded{
        "tracker-air", Scene::Campaign,
        "[{kind: tracker-air, at_point: 4, lasts_points: 2, temperature_c: 90, pressure_mbar: 100, humidity_percent: 0}]"}};

/// A program that goes a short way, of which little has to be recorded.
const Replacements kSmall{{"- [25, -80, 95, 20, 45, -30]", "- [1, -90, 90, 0, 35, 0]"},
                          {"- [15, -65, 75, -15, 50, 40]", "- [1, -90, 90, 0, 36, 0]"},
                          {"- [-20, -75, 85, -30, 30, 10]", "- [1, -90, 90, 0, 36, 1]"},
                          {"- [-10, -95, 105, 10, 55, -20]", "- [0, -90, 90, 0, 36, 1]"}};

class ARecordedCell {
 public:
  explicit ARecordedCell(const Recorded& recorded)
      : cell_{{.speedup = recorded.scene == Scene::Stream ? 2000.0 : 200.0,
               .faults = recorded.faults,
               .scenario = kSmall,
               .cell = {{"ring_mb: 64", "ring_mb: 4"}, {"ramp_ms: 1000", "ramp_ms: 400"}},
               .patient = true}} {
    cell_.start_daemon();
  }

  void campaign() {
    run({"connect"});
    run({"campaign", "start", "--identify", "12", "--validate", "2", "--no-activate", "--watch"});
  }
  void stream(int least, const std::string& then) {
    const Finished made = small_campaign(cell_);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    // A daemon that has recorded nothing yet.
    cell_.daemon().terminate();
    ASSERT_EQ(cell_.daemon().wait(), 0);
    cell_.start_daemon();
    run({"connect"});
    run({"stream", "start"});
    wait_for(least / 2);
    if (!then.empty()) cell_.steer(json::parse(then).as_object());
    wait_for(least);
  }
  void save(const std::filesystem::path& file) {
    const Finished saved = run({"recording", "save", "--out", file});
    EXPECT_EQ(saved.exit_code, 0) << saved.err;
  }

 private:
  void wait_for(int cycles_of_the_stream) {
    while (streams() && cycles() < cycles_of_the_stream)
      std::this_thread::sleep_for(std::chrono::milliseconds{20});
  }
  Finished run(const std::vector<std::string>& command) { return cell_.truepose(command); }
  json::value status() { return json::parse(run({"status", "--json"}).out); }
  bool streams() { return status().at("state") == "streaming"; }
  double cycles() { return number(status(), "/stream/cycles"); }

  LiveCell cell_;
};

void record(const Recorded& recorded, const std::filesystem::path& file) {
  ARecordedCell cell{recorded};
  recorded.scene == Scene::Stream ? cell.stream(recorded.cycles, recorded.then) : cell.campaign();
  cell.save(file);
}

/// What is recorded and where: everything where a folder is given, else the first into one that goes with the
/// test.
struct Recordings {
  TempFolder temporary;
  std::filesystem::path folder = temporary.path();
  std::span<const Recorded> all{kRecorded.data(), 1};

  Recordings() {
    const char* const given = std::getenv("TRUEPOSE_RECORDINGS");
    if (!given) return;
    folder = std::filesystem::absolute(given);
    all = kRecorded;
  }
};

TEST(ARecording, IsMadeOfAMisbehaviourAndGivesTheSameRepliesAgain) {
  const Recordings recordings;
  for (const Recorded& recorded : recordings.all) {
    SCOPED_TRACE(recorded.name);
    const auto file = recordings.folder / (std::string{recorded.name} + ".recording");
    record(recorded, file);
    const Finished replayed = run_program("truepose", {"replay", file, "--json"});
    ASSERT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
    const json::value report = json::parse(replayed.out);
    EXPECT_EQ(report.at_pointer("/robot/serial"), "210001");
    EXPECT_EQ(report.at("same"), true);
    EXPECT_EQ(report.at("dropped"), 0);
    if (recorded.scene == Scene::Campaign) continue;
    EXPECT_GE(number(report, "/stream/compared"), 100) << replayed.out;
    EXPECT_EQ(number(report, "/stream/different"), 0);
    const bool loses_replies = &recorded == kRecorded.data();
    EXPECT_GE(number(report, "/stream/counters/late"), loses_replies ? 40 : 0);
  }
}

}  // namespace
}  // namespace truepose
