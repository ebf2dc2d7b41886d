#include "config/cell_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>

#include "config/cell_setup.hpp"
#include "config/sealed_text.hpp"
#include "core/calibrate/option_names.hpp"
#include "core/math/angles.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

constexpr char kRobot[] =
    "name: r\njoints:\n  - {a: 0, alpha: 0, d: 1, theta: 0, sign: 1, min: 0, max: 1, speed: 1}\n";
constexpr char kSmallest[] = R"(name: test
robot: {file: robot.yaml, eki_motion: "10.0.0.1:54600", eki_state: "10.0.0.1:54601"}
stream: {listen: "[::1]:0", ethernet_xml: sub/../rsi.xml}
tracker: {address: tracker.local:700}
control: {token_file: token}
store: /var/lib/cell.sqlite
)";

class CellFile : public testing::Test {
 protected:
  CellFile() { folder_.write("robot.yaml", kRobot); }
  CellConfig load(const std::string& text) { return load_cell(folder_.write("cell.yaml", text)); }
  std::string error(const std::string& text) {
    const auto file = folder_.write("cell.yaml", text);
    return error_of([&] { load_cell(file); }, file);
  }
  std::string error_with(const std::string& from, const std::string& to) {
    std::string text = kSmallest;
    text.replace(text.find(from), from.size(), to);
    return error(text);
  }
  TempFolder folder_;
};

TEST_F(CellFile, NamesAShippedRobotAsTheCommandLineDoes) {
  std::string text = kSmallest;
  text.replace(text.find("robot.yaml"), 10, "kr210_r2700_2");
  const CellConfig cell = load(text);
  EXPECT_EQ(cell.robot.model.name, "KUKA KR 210 R2700-2");
  EXPECT_FALSE(cell.robot.body.empty());
  EXPECT_EQ(cell.robot.file.filename(), "kr210_r2700_2.yaml");
  EXPECT_THAT(
      error_with("robot.yaml", "kr210_r2700"),
      HasSubstr("cell.yaml:2:15: robot.file: kr210_r2700: no such file, and no shipped robot of this name"));
  folder_.write("kr210_r2700_2", kRobot);
  EXPECT_EQ(load(text).robot.model.name, "r") << "a file comes first";
}

TEST_F(CellFile, GivesWhatCampaignsGoByAsATextAndTakesItBack) {
  CellConfig cell = load(kSmallest);
  CampaignConfig& campaign = cell.campaign;
  campaign.identify_poses = 17;
  campaign.seed = 0xfedc'ba98'7654'3210;
  campaign.speed_percent = 100.0 / 3;
  campaign.settle = std::chrono::milliseconds{123};
  campaign.warm_up = std::chrono::seconds{600};
  campaign.criterion = DesignCriterion::D;
  campaign.approach = ApproachSide::Alternate;
  campaign.remeasure = false;
  cell.calibration = {true, {1, 2, 160}, FieldUse::Auto, Loss::Tukey};
  const std::string text = campaign_options(cell);

  CellConfig other = load(kSmallest);
  EXPECT_NE(campaign_options(other), text);
  use_campaign_options(other, text);
  EXPECT_EQ(campaign_options(other), text);
  EXPECT_EQ(other.campaign.seed, campaign.seed);
  EXPECT_EQ(other.campaign.speed_percent, campaign.speed_percent);
  EXPECT_EQ(other.campaign.warm_up, campaign.warm_up);
  EXPECT_EQ(other.calibration.field, cell.calibration.field);
  EXPECT_EQ(other.calibration.loss, Loss::Tukey);
  EXPECT_THROW(use_campaign_options(other, "campaign: {identify_poses: many}"), ConfigError);
}

TEST_F(CellFile, IsShownAsAFileThatReadsBackTheSame) {
  CellConfig cell = load(kSmallest);
  cell.robot.expect_model = "KR210";
  cell.loads = {{2, {12.5, {1, 2, 3}}}};
  cell.stream.rearm = Rearm::Automatic;
  cell.stream.max_step_deg = 0.013;
  cell.stream.p_FT_mm = {10, -20, 300};
  cell.tracker.reflector = "CCR-1.5in";
  cell.tracker.robot_base = pose_from_kuka({3000, -200, 900}, {0, 0, 0});
  cell.tracker.nests_mm = {{1, 2, 3}, {4, 5, 6}, {7, 8, -9}};
  cell.tracker.air_file = "/run/air";
  cell.further_reflectors = {{.name = "side", .p_FS_mm = {20, -110, 70}, .facing_F = {0.6, 0, 0.8}}};
  cell.campaign.seed = 0xfedc'ba98'7654'3210;
  cell.calibration = {true, {1, 2, 160}, FieldUse::Auto, Loss::Tukey};
  cell.iso9283.cube.centre_mm = {1500, 0, 900};
  cell.recording.max_files = 3;
  const json::object shown = cell_json(cell);

  json::object file = shown;
  file["robot"].as_object().erase("model");
  file["control"].as_object()["token_file"] = "token";
  EXPECT_EQ(json::serialize(cell_json(load(json::serialize(file)))), json::serialize(shown));
}

TEST_F(CellFile, IsShownWithoutSecrets) {
  CellConfig cell = load(kSmallest);
  cell.control.token_file = "/secret/token";
  cell.control.tls = TlsConfig{{"0.0.0.0", 7211}, "/secret/certificate", "/secret/key"};
  EXPECT_EQ(json::serialize(cell_json(cell)).find("secret"), std::string::npos);
}

TEST_F(CellFile, IsShownWithoutAnAddressWhereTheWebPortIsOff) {
  CellConfig cell = load(kSmallest);
  EXPECT_EQ(cell_json(cell).at("web").at("listen"), "127.0.0.1:7280");
  cell.web = WebConfig{std::nullopt};
  EXPECT_TRUE(cell_json(cell).at("web").at("listen").is_null());
}

TEST_F(CellFile, ReadsWhereAnIso9283TestIsMeasured) {
  const CellConfig cell = load(std::string{kSmallest} +
                               "iso9283: {cycles: 5, variation: true, plane: C2-C3-C8-C5, edge_mm: 400,"
                               " centre: {x: 1, y: 2, z: 3}, orientation: {a: 90, b: 0, c: 0}}\n");
  EXPECT_EQ(cell.iso9283.cycles, 5);
  EXPECT_TRUE(cell.iso9283.variation);
  EXPECT_FALSE(load(kSmallest).iso9283.variation);
  EXPECT_EQ(cell.iso9283.cube.plane, DiagonalPlane::C2C3C8C5);
  EXPECT_EQ(cell.iso9283.cube.edge_mm, 400);
  EXPECT_EQ(cell.iso9283.cube.centre_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR((*cell.iso9283.cube.orientation)(1, 0), 1, 1e-12);
  EXPECT_FALSE(load(kSmallest).iso9283.cube.edge_mm);
}

TEST_F(CellFile, TakesTheAirFromOnePlaceAlone) {
  const std::string tracker = "tracker: {address: tracker.local:700";
  const auto with = [&](const std::string& more) {
    std::string text = kSmallest;
    return text.replace(text.find(tracker), tracker.size(), tracker + more);
  };
  const std::string entered = ", air: {temperature_c: 21, pressure_mbar: 1000, humidity_percent: 30}";
  EXPECT_EQ(load(with(entered)).tracker.air, (Air{21, 1000, 30}));
  EXPECT_EQ(load(with(", air_file: air.yaml")).tracker.air_file, folder_.path() / "air.yaml");
  EXPECT_THAT(error(with(entered + ", air_file: air.yaml")), HasSubstr("air is given already"));
}

TEST_F(CellFile, BoundsTargetsNextToTheWristSingularityAsTheStream) {
  CellConfig cell = load(kSmallest);
  cell.stream.singularity_threshold_deg = 7;
  EXPECT_NEAR(compensation_options(cell).singular_below, 7 * kRadPerDeg, 1e-12);
}

TEST_F(CellFile, KeepsTheReflectorThereUnlessATcpIsNamed) {
  const CalibratedCell model{.robot = {}, .base = {}, .reflectors = {{"1", {1, 2, 3}}}};
  CellConfig cell = load(kSmallest);
  EXPECT_EQ(corrected_arm(cell, model, nullptr)->p_F_mm, Eigen::Vector3d(1, 2, 3));
  cell.stream.p_FT_mm = Eigen::Vector3d(0, 0, 250);
  EXPECT_EQ(corrected_arm(cell, model, nullptr)->p_F_mm, Eigen::Vector3d(0, 0, 250));
}

TEST_F(CellFile, LoadsTheArmByTheToolInForceWhereTheModelKnowsHowItBends) {
  const std::string loads = std::string{kSmallest} + "loads: [{tool: 2, kg: 15, x: 0, y: 10, z: 120}]\n";
  const CellConfig cell = load(loads);
  EXPECT_EQ(load_of(cell, 3), nullptr);
  EXPECT_EQ(load_of(cell, std::nullopt), nullptr);
  ASSERT_TRUE(load_of(cell, 2));
  EXPECT_THAT(error(std::string{kSmallest} + "loads: [{tool: 1, kg: 1, x: 0, y: 0, z: 0}, "
                                             "{tool: 1, kg: 2, x: 0, y: 0, z: 0}]\n"),
              HasSubstr("two loads of tool 1"));

  CalibratedCell model{.robot = {}, .base = {}, .reflectors = {{"1", {1, 2, 3}}}};
  EXPECT_THAT(corrected_arm(cell, model, nullptr, load_of(cell, 2)).error(),
              HasSubstr("has no gravity compliance for a payload"));
  model.robot.deviation = {{0, DeviationBasis::Gravity, 1, 1e-4}};
  EXPECT_EQ(corrected_arm(cell, model, nullptr, load_of(cell, 2))->robot.payload,
            (LinkMass{15, {0, 10, 120}}));
  model.robot.masses = {{.mass_kg = 20}};
  EXPECT_THAT(corrected_arm(cell, model, nullptr, load_of(cell, 2)).error(),
              HasSubstr("does not say what the arm carried"));
}

TEST_F(CellFile, NamesMeasuredToolsAndTheOneInForce) {
  const std::string of_tool =
      "number: 3\nframe: {x: 1, y: 2, z: 3, a: 90, b: 0, c: 0}\npoints: [{name: origin}]\n"
      "readings: [{point: 1, q: [0.5], seen: {x: 1, y: 2, z: 3}}]\n";
  folder_.write("gun.yaml", sealed(of_tool + "arm: r\n"));
  const std::string tools = std::string{kSmallest} + "tools: [gun.yaml]\n";
  const CellConfig cell = load(tools);
  ASSERT_TRUE(tool_of(cell, 3));
  EXPECT_EQ(tool_of(cell, 3)->X_controller.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(tool_of(cell, 4), nullptr);
  EXPECT_THAT(error(std::string{kSmallest} + "tools: [gun.yaml, gun.yaml]\n"),
              HasSubstr("another file is of tool 3 too"));
  folder_.write("gun.yaml", sealed(of_tool + "arm: other\n"));
  EXPECT_THAT(error(tools), HasSubstr("the tool of 'other', but the arm is 'r'"));
}

TEST_F(CellFile, KeepsTheDefaultsOfWhatIsLeftOut) {
  const CellConfig cell = load(kSmallest), defaults;
  EXPECT_EQ(cell.name, "test");
  EXPECT_EQ(cell.robot.model.name, "r");
  EXPECT_EQ(cell.robot.max_fk_deviation_mm, defaults.robot.max_fk_deviation_mm);
  EXPECT_EQ(cell.stream.cycle, defaults.stream.cycle);
  EXPECT_EQ(cell.stream.realtime, defaults.stream.realtime);
  EXPECT_EQ(cell.tracker.gate_mm, defaults.tracker.gate_mm);
  EXPECT_EQ(cell.reflector.facing_F, defaults.reflector.facing_F);
  EXPECT_EQ(cell.campaign.identify_poses, defaults.campaign.identify_poses);
  EXPECT_EQ(cell.control.listen.port, 7210);
  EXPECT_EQ(cell.log_level, "info");
}

TEST_F(CellFile, ReadsAddressesAndResolvesPathsFromItsOwnFolder) {
  const CellConfig cell = load(kSmallest);
  EXPECT_EQ(cell.robot.eki_motion.host, "10.0.0.1");
  EXPECT_EQ(cell.robot.eki_motion.port, 54600);
  EXPECT_EQ(cell.stream.listen.host, "::1");
  EXPECT_EQ(cell.stream.listen.port, 0);
  EXPECT_EQ(cell.tracker.address.host, "tracker.local");
  EXPECT_EQ(cell.robot.file, folder_.path() / "robot.yaml");
  EXPECT_EQ(cell.stream.ethernet_xml, folder_.path() / "rsi.xml");
  EXPECT_EQ(cell.control.token_file, folder_.path() / "token");
  EXPECT_EQ(cell.store, "/var/lib/cell.sqlite");
  EXPECT_EQ(cell.runtime, "");
  EXPECT_EQ(load(std::string{kSmallest} + "runtime: run\n").runtime, folder_.path() / "run");
}

TEST_F(CellFile, KeepsRecordingsInTheStoresFolderUnlessAFolderIsNamed) {
  EXPECT_EQ(load(kSmallest).recording.folder, "/var/lib/cell.sqlite.recordings");
  const CellConfig cell =
      load(std::string{kSmallest} + "recording: {folder: here, ring_mb: 8, max_files: 3}\n");
  EXPECT_EQ(cell.recording.folder, folder_.path() / "here");
  EXPECT_EQ(cell.recording.ring_mb, 8U);
  EXPECT_EQ(cell.recording.max_files, 3U);
  EXPECT_EQ(cell.recording.max_mb, RecordingConfig{}.max_mb);
}

TEST_F(CellFile, ConvertsPlacementAndFacing) {
  std::string text = kSmallest;
  text.replace(text.find("700}"), 4,
               "700, robot_base: {x: 1, y: 2, z: 3, a: 170, b: 1, c: -1}, measure_ms: 1500}");
  const CellConfig cell =
      load(text + "reflector: {facing: {x: 0, y: 3, z: 4}, offset_mm: {x: 62, y: -48, z: 187}}\n");
  EXPECT_TRUE(cell.tracker.robot_base.isApprox(pose_from_kuka({1, 2, 3}, {170, 1, -1})));
  EXPECT_EQ(cell.tracker.measure, std::chrono::milliseconds(1500));
  EXPECT_TRUE(cell.reflector.facing_F.isApprox(Eigen::Vector3d(0, 0.6, 0.8)));
  EXPECT_EQ(cell.reflector.p_FS_mm, Eigen::Vector3d(62, -48, 187));
}

TEST_F(CellFile, RefusesBadAddresses) {
  EXPECT_EQ(error_with("tracker.local:700", "tracker.local:99999"),
            "cell.yaml:4:20: tracker.address: expected a port of 1..65535, found '99999'");
  EXPECT_EQ(error_with("tracker.local:700", "tracker.local:0"),
            "cell.yaml:4:20: tracker.address: expected a port of 1..65535, found '0'");
  EXPECT_EQ(error_with("tracker.local:700", "tracker.local:7x"),
            "cell.yaml:4:20: tracker.address: expected a port of 1..65535, found '7x'");
  EXPECT_EQ(error_with("tracker.local:700", "tracker.local"),
            "cell.yaml:4:20: tracker.address: expected host:port, found 'tracker.local'");
  EXPECT_EQ(
      error_with("[::1]:0", "::1:7"),
      "cell.yaml:3:18: stream.listen: expected host:port, found '::1:7': an IPv6 address stands in brackets");
}

TEST(Endpoint, IsPrintedAsItIsParsed) {
  for (const std::string address :
       {"127.0.0.1:7210", "tracker.local:700", "[::1]:0", "[fe80::1%eth0]:54600"}) {
    const auto endpoint = parse_endpoint(address, 0);
    ASSERT_TRUE(endpoint) << endpoint.error();
    EXPECT_EQ(text(*endpoint), address);
  }
}

TEST_F(CellFile, NamesPlaceAndPathOfEveryMistake) {
  EXPECT_EQ(error_with("tracker:", "trakcer:"),
            "cell.yaml:4:1: trakcer: unknown key, did you mean 'tracker'?");
  EXPECT_EQ(error_with("{token_file: token}", "{}"), "cell.yaml:5:10: control: missing key 'token_file'");
  EXPECT_EQ(error_with("store:", "#store:"), "cell.yaml:1:1: missing key 'store'");
  EXPECT_EQ(error_with("token}", "token, listen: 7210}"),
            "cell.yaml:5:38: control.listen: expected host:port, found '7210'");
  EXPECT_EQ(error_with("rsi.xml}", "rsi.xml, cycle_ms: 4.5}"),
            "cell.yaml:3:69: stream.cycle_ms: expected a whole number, found 4.5");
  EXPECT_EQ(error_with("rsi.xml}", "rsi.xml, priority: 99}"),
            "cell.yaml:3:69: stream.priority: expected 1..80, found 99");
  EXPECT_EQ(error_with("rsi.xml}", "rsi.xml, realtime: on}"),
            "cell.yaml:3:69: stream.realtime: expected one of require, prefer, off, found 'on'");
  EXPECT_EQ(error(std::string(kSmallest) + "campaign: {remeasure: yes}\n"),
            "cell.yaml:7:23: campaign.remeasure: expected true or false, found 'yes'");
  EXPECT_EQ(error(std::string(kSmallest) + "recording: {ring_mb: 0}\n"),
            "cell.yaml:7:22: recording.ring_mb: expected 1..4096, found 0");
  EXPECT_EQ(error(std::string(kSmallest) + "recording: {ring_mb: 100000000}\n"),
            "cell.yaml:7:22: recording.ring_mb: expected 1..4096, found 100000000");
  EXPECT_EQ(error(std::string(kSmallest) + "recording: {max_files: 0}\n"),
            "cell.yaml:7:24: recording.max_files: expected 1..1000, found 0");
  EXPECT_EQ(error(std::string(kSmallest) + "campaign: {seed: -1}\n"),
            "cell.yaml:7:18: campaign.seed: expected a whole number from 0 to 2^64 - 1, found '-1'");
  EXPECT_EQ(
      error(std::string(kSmallest) + "campaign: {identify_poses: 6}\n"),
      "cell.yaml:7:11: campaign: coarse_after is more than identify_poses: expected at most 6, found 8");
  EXPECT_EQ(error(std::string(kSmallest) + "reflector: {facing: {x: 0, y: 0, z: 0}}\n"),
            "cell.yaml:7:21: reflector.facing: a direction of no length");
  EXPECT_EQ(error(std::string(kSmallest) + "log_level: loud\n"),
            "cell.yaml:7:12: log_level: expected one of trace, debug, info, warn, error, found 'loud'");
}

TEST_F(CellFile, RefusesAnOldKeyWithItsNewName) {
  struct Old {
    const char *before, *key, *value, *new_key;
  };
  const auto refused = [&](const std::string& text, const Old& old) {
    EXPECT_THAT(text, HasSubstr(std::string{old.key} + ": unknown key, renamed to '" + old.new_key + "'"));
  };
  for (const Old& old : {Old{"{address:", "placement", "{x: 0}", "robot_base"},
                         Old{"{address:", "initialise_again_min", "30", "reinitialise_after_min"},
                         Old{"{address:", "search_first_mm", "300", "first_search_radius_mm"},
                         Old{"{address:", "search_mm", "30", "search_radius_mm"},
                         Old{"{listen:", "singular_deg", "20", "singularity_threshold_deg"}})
    refused(error_with(old.before, "{" + std::string{old.key} + ": " + old.value + ", " + (old.before + 1)),
            old);
  for (const Old& old :
       {Old{"campaign", "wrist_margin_deg", "3", "singularity_margin_deg"},
        Old{"recording", "most_files", "20", "max_files"}, Old{"recording", "most_mb", "500", "max_mb"},
        Old{"calibration", "deviation", "auto", "non_geometric"}})
    refused(error(std::string{kSmallest} + old.before + ": {" + old.key + ": " + old.value + "}\n"), old);
  EXPECT_THAT(error(std::string{kSmallest} + "calibration: {loss: screened}\n"),
              HasSubstr("found 'screened', renamed to 'outlier-rejection'"));
}

TEST_F(CellFile, RefusesTextThatIsNoUtf8) {
  EXPECT_EQ(error_with("name: test", "name: Zelle-\xE4"),
            "cell.yaml:1:7: byte 0xE4 in this text is not UTF-8: save the file in UTF-8");
  EXPECT_EQ(error_with("token_file: token}", "token_file: \"\xC3\"}"),
            "cell.yaml:5:23: byte 0xC3 in this text is not UTF-8: save the file in UTF-8");
  EXPECT_EQ(error_with("name: test", "n\xFCme: test"),
            "cell.yaml:1:1: byte 0xFC in this text is not UTF-8: save the file in UTF-8");
  std::string text = kSmallest;
  EXPECT_EQ(load(text.replace(0, 10, "name: Zelle-\xC3\xA4 \xEF\xBF\xBD  # Gr\xFC\xDF\x65")).name,
            "Zelle-\xC3\xA4 \xEF\xBF\xBD")
      << "a comment is nobody's text";
}

TEST_F(CellFile, SaysWhereTheWebPortIsOrThatThereIsNone) {
  EXPECT_FALSE(load(kSmallest).web) << "as usual, and without it where the port is taken";
  EXPECT_EQ(load(std::string(kSmallest) + "web: {}\n").web->listen->port, 7280);
  EXPECT_EQ(load(std::string(kSmallest) + "web: {listen: off}\n").web->listen.has_value(), false);
  const CellConfig cell =
      load(std::string(kSmallest) + "web: {listen: \"[::1]:80\", origins: [https://hmi.plant:8443]}\n");
  EXPECT_EQ(cell.web->listen->host, "::1");
  EXPECT_EQ(cell.web->origins.front(), "https://hmi.plant:8443");
  EXPECT_EQ(
      error(std::string(kSmallest) + "web: {origins: [hmi.plant]}\n"),
      "cell.yaml:7:16: web.origins: expected origins as browsers send them, as https://hmi.plant, found "
      "'hmi.plant'");
}

TEST_F(CellFile, ListsSeveralReflectorsOfDifferentNames) {
  const CellConfig cell =
      load(std::string(kSmallest) +
           "reflectors: [{name: a, offset_mm: {x: 1, y: 2, z: 3}}, {acceptance_deg: 45}]\n");
  EXPECT_EQ(cell.reflector.name, "a");
  EXPECT_EQ(cell.reflector.p_FS_mm, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(cell.further_reflectors.size(), 1U);
  EXPECT_EQ(cell.further_reflectors[0].name, "2");
  EXPECT_EQ(cell.further_reflectors[0].acceptance_deg, 45);
  EXPECT_EQ(error(std::string(kSmallest) + "reflectors: []\n"),
            "cell.yaml:7:13: reflectors: expected 1 to 6 reflectors, found 0");
  EXPECT_EQ(error(std::string(kSmallest) + "reflectors: [{name: a}, {name: a}]\n"),
            "cell.yaml:7:25: reflectors[2]: another reflector is called \"a\" too");
  EXPECT_EQ(error(std::string(kSmallest) + "reflector: {}\nreflectors: [{}]\n"),
            "cell.yaml:8:13: reflectors: reflector is given already: leave one of them out");
}

TEST_F(CellFile, SaysWhatIsSpokenWithTheTracker) {
  EXPECT_EQ(load(kSmallest).tracker.protocol, TrackerProtocol::Emscon);
  std::string text = kSmallest;
  text.replace(text.find("{address: tracker"), 1, "{protocol: bridge, reinitialise_after_min: 30, ");
  const TrackerConfig tracker = load(text).tracker;
  EXPECT_EQ(tracker.protocol, TrackerProtocol::Bridge);
  EXPECT_EQ(tracker.reinitialise_after, std::chrono::minutes{30});
}

TEST_F(CellFile, TakesEveryNameThatTheCommandLineTakes) {
  for (const auto& field : kFieldNames) {
    const CellConfig cell =
        load(std::string(kSmallest) + "calibration: {residual: " + std::string(field.name) + "}\n");
    EXPECT_EQ(cell.calibration.field, field.value) << field.name;
  }
  for (const auto& loss : kLossNames) {
    const CellConfig cell =
        load(std::string(kSmallest) + "calibration: {loss: " + std::string(loss.name) + "}\n");
    EXPECT_EQ(cell.calibration.loss, loss.value) << loss.name;
  }
  EXPECT_EQ(error(std::string(kSmallest) + "calibration: {residual: fields}\n"),
            "cell.yaml:7:25: calibration.residual: expected one of none, auto, gp, found 'fields'");
}

TEST_F(CellFile, ReportsAMistakeInTheRobotFileThere) {
  folder_.write("robot.yaml", "name: r\n");
  EXPECT_EQ(error(kSmallest), "robot.yaml:1:1: missing key 'joints'");
}

TEST(OtherToolData, ComparesTheOrientationOfA6DTargetAlone) {
  ToolFile tool{.number = 3, .data = {.points = {{kOrigin, {}}}, .readings = {FrameReading{}}}};
  Eigen::Isometry3d X = tool.X_controller;
  X.rotate(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(other_tool_data(tool, X), "");
  X.translation().z() += 1;
  EXPECT_THAT(other_tool_data(tool, X), HasSubstr("put the measured X, Y, Z into TOOL_DATA[3]"));
  tool.data.readings[0].orientation.emplace();
  EXPECT_THAT(other_tool_data(tool, X), HasSubstr("is 1.000 mm and 0.5730 deg from the measured one"));
}

}  // namespace
}  // namespace truepose::config
