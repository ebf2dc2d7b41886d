#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/json/parse.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/await.hpp"
#include "tests/integration/campaign_events.hpp"
#include "tests/integration/live_cell.hpp"

// A daemon is recorded while the simulated cell misbehaves. With TRUEPOSE_RECORDINGS=FOLDER every
// misbehaviour is, and the recordings are kept there: those of tests/recordings, which other tests replay,
// were made so.

namespace truepose {
namespace {

namespace json = boost::json;

/// What is recorded; a campaign also of a tracker that speaks through a bridge.
enum class Scene { Stream, Campaign, BridgeCampaign };

struct Recorded {
  const char* name;
  Scene scene;
  const char* faults;       ///< from the beginning
  const char* then = "";    ///< what befalls it later, for the simulator's admin port: a stream after half of
                            ///< its cycles, a campaign at every fifth pose
  int cycles = 300;         ///< of a stream
  const char* mended = "";  ///< what is done about it when a device has to be waited for
};

/// In the midst of some measurements, and of some searches.
constexpr const char* kInterrupted = "[{kind: beam-break, at_ms: 20000, lasts_ms: 500, every_ms: 9000}]";

constexpr std::array kRecorded{
    Recorded{"rsi-lose-replies", Scene::Stream,
             "[{kind: rsi-lose-replies, at_cycle: 150, lasts_cycles: 20, every_cycles: 50}]"},
    Recorded{"rsi-drop", Scene::Stream, "[{kind: rsi-drop, at_cycle: 150, lasts_cycles: 30}]"},
    Recorded{"rsi-lose-datagrams", Scene::Stream,
             "[{kind: rsi-lose-datagrams, at_cycle: 150, lasts_cycles: 5, every_cycles: 50}]"},
    Recorded{"rsi-duplicate", Scene::Stream, "[{kind: rsi-duplicate, at_cycle: 150, lasts_cycles: 50}]"},
    Recorded{"rsi-reorder", Scene::Stream, "[{kind: rsi-reorder, at_cycle: 150, lasts_cycles: 50}]"},
    Recorded{"rsi-late", Scene::Stream, "[{kind: rsi-late, at_cycle: 150, lasts_cycles: 50}]"},
    Recorded{"rsi-corrupt", Scene::Stream,
             "[{kind: rsi-corrupt, at_cycle: 150, lasts_cycles: 5, every_cycles: 50}]"},
    Recorded{"rsi-silence", Scene::Stream, "[{kind: rsi-silence, at_cycle: 150, lasts_cycles: 100000}]"},
    Recorded{"rsi-restart", Scene::Stream, "[{kind: rsi-restart, at_cycle: 150}]"},
    Recorded{"rsi-ipoc", Scene::Stream, "[{kind: rsi-ipoc, at_cycle: 150, ipoc_by: 1000}]"},
    Recorded{"rsi-ignore", Scene::Stream, "[{kind: rsi-ignore, at_cycle: 2}]", "", 700},
    Recorded{"rsi-second-sender", Scene::Stream,
             "[{kind: rsi-second-sender, at_cycle: 150, lasts_cycles: 50, from: 127.0.0.2}]"},
    Recorded{"program-stop", Scene::Stream, "[]", R"({"kind": "program-stop", "lasts_ms": 200000})", 220},
    Recorded{"emergency-stop", Scene::Stream, "[]", R"({"kind": "emergency-stop"})", 220},
    Recorded{"controller-restart", Scene::Stream, "[]",
             R"({"kind": "controller-restart", "lasts_ms": 200000})", 220},
    Recorded{"eki-drop", Scene::Campaign, "[]", R"({"kind": "eki-drop"})"},
    Recorded{"beam-break", Scene::Campaign, kInterrupted},
    Recorded{"tracker-restart", Scene::Campaign, "[]", R"({"kind": "tracker-restart"})"},
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
        "[{kind: tracker-air, at_point: 4, lasts_points: 2, temperature_c: 90, pressure_mbar: 100, humidity_percent: 0}]"},
    Recorded{"tracker-stray", Scene::Campaign,
             "[{kind: tracker-stray, at_point: 4, lasts_points: 2, by_mm: {x: 3, y: 0, z: 4}}]"},
    Recorded{"tracker-busy", Scene::Campaign, "[]", R"({"kind": "tracker-busy", "lasts_ms": 400000})"},
    Recorded{"tracker-silent", Scene::Campaign, "[]", R"({"kind": "tracker-silent", "lasts_ms": 1200000})"},
    Recorded{"tracker-storm", Scene::Campaign, "[]", R"({"kind": "tracker-storm", "lasts_ms": 400000})"},
    Recorded{"gate-open", Scene::Campaign, "[]", R"({"kind": "gate-open", "lasts_ms": 400000})"},
    Recorded{"operating-mode", Scene::Campaign, "[]",
             R"({"kind": "operating-mode", "lasts_ms": 400000, "mode": "T1"})"},
    Recorded{"override", Scene::Campaign, "[]", R"({"kind": "override", "lasts_ms": 400000, "percent": 10})"},
    Recorded{"program-reset", Scene::Campaign, "[]", R"({"kind": "program-reset", "lasts_ms": 400000})"},
    Recorded{"program-select", Scene::Campaign, "[]", R"({"kind": "program-select", "program": "GLUING"})", 0,
             R"({"kind": "program-select", "program": "TRUEPOSE_MOTION"})"},
    Recorded{"campaign-emergency-stop", Scene::Campaign, "[]",
             R"({"kind": "emergency-stop", "lasts_ms": 400000})"},
    Recorded{"campaign-program-stop", Scene::Campaign, "[]",
             R"({"kind": "program-stop", "lasts_ms": 400000})"},
    Recorded{"campaign-controller-restart", Scene::Campaign, "[]",
             R"({"kind": "controller-restart", "lasts_ms": 400000})"},
    Recorded{"bridge-restart", Scene::BridgeCampaign, "[]", R"({"kind": "tracker-restart"})"},
    Recorded{"bridge-beam-break", Scene::BridgeCampaign, kInterrupted},
    Recorded{"bridge-busy", Scene::BridgeCampaign, "[]", R"({"kind": "tracker-busy", "lasts_ms": 400000})"},
    Recorded{"bridge-silent", Scene::BridgeCampaign, "[]",
             R"({"kind": "tracker-silent", "lasts_ms": 1200000})"}};

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
               .patient = true,
               .bridge = recorded.scene == Scene::BridgeCampaign}} {
    cell_.start_daemon();
  }

  void campaign(const std::string& then, const std::string& mended) {
    const auto events = campaign_in_trouble(
        cell_, {{"identify_poses", 12}, {"validate_poses", 2}, {"activate", false}},
        [&](std::int64_t measured) { return measured % 5 == 0 ? object_of(then) : json::object{}; },
        object_of(mended));
    if (then.empty()) return;
    EXPECT_EQ(events.back().data.at("phase"), "done") << cell_.daemon().errors();
    // A slower arm and more to read past are no trouble.
    const bool quiet = then.contains("override") || then.contains("tracker-storm");
    EXPECT_NE(std::ranges::any_of(events, tells_of_trouble), quiet);
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
    if (!then.empty()) cell_.steer(object_of(then));
    wait_for(least);
  }
  void save(const std::filesystem::path& file) {
    const Finished saved = run({"recording", "save", "--out", file});
    EXPECT_EQ(saved.exit_code, 0) << saved.err;
  }

 private:
  static json::object object_of(const std::string& text) {
    return text.empty() ? json::object{} : json::parse(text).as_object();
  }
  static bool tells_of_trouble(const control::Event& event) {
    if (event.topic == "cell")
      return is_loss(event) && !text_of(event, "reason").contains("it has to connect");
    return event.topic == "log" && text_of(event, "text").contains(", attempt ");
  }
  static std::string text_of(const control::Event& event, const char* member) {
    return std::string{event.data.at(member).as_string()};
  }
  void wait_for(int cycles_of_the_stream) {
    await("the stream has run for " + std::to_string(cycles_of_the_stream) + " cycles or ended",
          [&] { return !streams() || cycles() >= cycles_of_the_stream; });
  }
  Finished run(const std::vector<std::string>& command) { return cell_.truepose(command); }
  json::value status() { return json::parse(run({"status", "--json"}).out); }
  bool streams() { return status().at("state") == "streaming"; }
  double cycles() { return number(status(), "/stream/cycles"); }

  LiveCell cell_;
};

void record(const Recorded& recorded, const std::filesystem::path& file) {
  ARecordedCell cell{recorded};
  recorded.scene == Scene::Stream ? cell.stream(recorded.cycles, recorded.then)
                                  : cell.campaign(recorded.then, recorded.mended);
  cell.save(file);
}

/// Into a folder that is given, or one that goes with the test.
class ARecording : public testing::TestWithParam<Recorded> {
 protected:
  static const char* given_folder() { return std::getenv("TRUEPOSE_RECORDINGS"); }

 public:
  /// Everything where a folder is given, else the first of each scene.
  static std::vector<Recorded> recorded() {
    if (given_folder()) return {kRecorded.begin(), kRecorded.end()};
    std::vector<Recorded> few;
    for (const Scene scene : {Scene::Stream, Scene::Campaign, Scene::BridgeCampaign})
      few.push_back(*std::ranges::find(kRecorded, scene, &Recorded::scene));
    return few;
  }
  static std::string name(const testing::TestParamInfo<Recorded>& info) {
    std::string name = info.param.name;
    std::ranges::replace(name, '-', '_');
    return name;
  }

 protected:
  TempFolder temporary_;
  std::filesystem::path folder_ =
      given_folder() ? std::filesystem::absolute(given_folder()) : temporary_.path();
};

TEST_P(ARecording, IsMadeOfAMisbehaviourAndGivesTheSameAgain) {
  const Recorded& recorded = GetParam();
  const auto file = folder_ / (std::string{recorded.name} + ".recording");
  record(recorded, file);
  const Finished replayed = run_program("truepose", {"replay", file, "--json"});
  ASSERT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  const json::value report = json::parse(replayed.out);
  EXPECT_EQ(report.at_pointer("/robot/serial"), "210001");
  EXPECT_EQ(report.at("same"), true);
  EXPECT_EQ(report.at("dropped"), 0);
  ASSERT_EQ(report.at("drivers").as_array().size(), 2U);
  for (const char* const driver : {"/drivers/0", "/drivers/1"}) {
    EXPECT_GE(number(report.at_pointer(driver), "/same"), 1) << replayed.out;
    EXPECT_EQ(number(report.at_pointer(driver), "/different"), 0) << replayed.out;
  }
  if (recorded.scene != Scene::Stream) return;
  EXPECT_GE(number(report, "/stream/compared"), 100) << replayed.out;
  EXPECT_EQ(number(report, "/stream/different"), 0);
  const bool loses_replies = recorded.name == std::string_view{kRecorded.front().name};
  EXPECT_GE(number(report, "/stream/counters/late"), loses_replies ? 40 : 0);
}

void PrintTo(const Recorded& recorded, std::ostream* out) { *out << recorded.name; }

INSTANTIATE_TEST_SUITE_P(Of, ARecording, testing::ValuesIn(ARecording::recorded()), ARecording::name);

}  // namespace
}  // namespace truepose
