#include "config/scenario.hpp"

#include <gtest/gtest.h>

#include "core/math/angles.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

constexpr char kArmOfScenario[] =
    "name: r\njoints:\n"
    "  - {a: 1, alpha: 90, d: 2, theta: 0, sign: 1, min: -90, max: 90, speed: 1}\n"
    "  - {a: 3, alpha: 0, d: 4, theta: 0, sign: 1, min: -90, max: 90, speed: 1}\n";
constexpr char kScenario[] =
    "robot: robot.yaml\n"
    "robot_base: {x: 1, y: 2, z: 3, a: 0, b: 0, c: 0}\n"
    "reflector: {offset_mm: {x: 1, y: 2, z: 3}}\n"
    "rsi: {ethernet_xml: rsi.xml}\n";

class ScenarioFile : public testing::Test {
 protected:
  ScenarioFile() { folder_.write("robot.yaml", kArmOfScenario); }
  Scenario load(const std::string& more) { return load_scenario(folder_.write("s.yaml", kScenario + more)); }
  std::string error(const std::string& more) {
    const auto file = folder_.write("s.yaml", kScenario + more);
    return error_of([&] { load_scenario(file); }, file);
  }
  TempFolder folder_;
};

TEST_F(ScenarioFile, WithoutErrorsTheTruthIsTheNominalArm) {
  const Scenario scenario = load("");
  EXPECT_EQ(scenario.truth.joints[1].d_mm, 4);
  EXPECT_EQ(scenario.X_WB.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scenario.cycle, std::chrono::milliseconds(4));
}

TEST_F(ScenarioFile, SaysHowTheTrackerWarmsUpHowItsTripodGivesWayAndWhatIsOnTheFlange) {
  const Scenario scenario = load(
      "tracker: {warm_up: {range_mm: 0.02, horizontal_urad: 20, minutes: 15}, "
      "tripod: {mm_per_hour: {x: 0.1, y: 0, z: 0}, urad_per_hour: {x: 0, y: 0, z: 30}}}\n"
      "further_reflectors: [{offset_mm: {x: 4, y: 5, z: 6}, acceptance_deg: 45}]\n"
      "faults: [{at_point: 3, kind: tracker-stray, by_mm: {x: 0, y: 70, z: 0}, lasts_points: 1}]\n");
  EXPECT_EQ(scenario.instrument.warming.range_mm, 0.02);
  EXPECT_NEAR(scenario.instrument.warming.horizontal_rad, 20e-6, 1e-15);
  EXPECT_EQ(scenario.instrument.warming.minutes, 15);
  EXPECT_EQ(scenario.instrument.stand.mm_per_hour.x(), 0.1);
  EXPECT_NEAR(scenario.instrument.stand.rad_per_hour.z(), 30e-6, 1e-15);
  ASSERT_EQ(scenario.further_reflectors.size(), 1U);
  EXPECT_EQ(scenario.further_reflectors[0].p_FS_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_NEAR(scenario.further_reflectors[0].acceptance_rad, 45 * kRadPerDeg, 1e-12);
  ASSERT_EQ(scenario.faults.size(), 1U);
  EXPECT_EQ(scenario.faults[0].kind, ScenarioFault::Kind::TrackerStray);
}

TEST_F(ScenarioFile, AddsListedErrorsInMillimetresAndRadians) {
  const Scenario scenario = load("errors:\n  - {a: 0.5, beta: 0.001}\n  - {theta: 0.002, d: -0.25}\n");
  EXPECT_EQ(scenario.truth.joints[0].a_mm, 1.5);
  EXPECT_EQ(scenario.truth.joints[0].beta_rad, 0.001);
  EXPECT_EQ(scenario.truth.joints[0].alpha_rad, scenario.nominal.joints[0].alpha_rad);
  EXPECT_EQ(scenario.truth.joints[1].theta_rad, 0.002);
  EXPECT_EQ(scenario.truth.joints[1].d_mm, 3.75);
}

TEST_F(ScenarioFile, DrawsTheSameErrorsForTheSameSeedWithinTheirBounds) {
  const Scenario one = load("errors: {seed: 1, mm: 0.5, rad: 0.003}\n");
  const Scenario again = load("errors: {seed: 1, mm: 0.5, rad: 0.003}\n");
  const Scenario two = load("errors: {seed: 2, mm: 0.5, rad: 0.003}\n");
  EXPECT_EQ(one.truth.joints[0].a_mm, again.truth.joints[0].a_mm);
  EXPECT_NE(one.truth.joints[0].a_mm, two.truth.joints[0].a_mm);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LE(std::abs(one.truth.joints[i].d_mm - one.nominal.joints[i].d_mm), 0.5);
    EXPECT_LE(std::abs(one.truth.joints[i].theta_rad - one.nominal.joints[i].theta_rad), 0.003);
    EXPECT_NE(one.truth.joints[i].theta_rad, one.nominal.joints[i].theta_rad);
  }
}

TEST_F(ScenarioFile, DescribesWhatBecomesOfTheArmAsItWarmsUp) {
  EXPECT_EQ(load("").warm_up.zero.size(), 0);
  const WarmUp warm_up = load("warm_up: {zero: [0.01, -0.02], expansion_ppm: 150, minutes: 40}\n").warm_up;
  ASSERT_EQ(warm_up.zero.size(), 2);
  EXPECT_NEAR(warm_up.zero[1], -0.02 * kRadPerDeg, 1e-18);
  EXPECT_NEAR(warm_up.growth, 150e-6, 1e-18);
  EXPECT_EQ(warm_up.time_constant, Seconds{2400});
  EXPECT_EQ(error("warm_up: {zero: [0.01]}\n"),
            "s.yaml:5:10: warm_up: zero: expected one for each of the 2 joints");
}

TEST_F(ScenarioFile, DescribesOtherErrorsOfTheJoints) {
  EXPECT_TRUE(load("").drives.drives.empty());
  std::string text = kScenario;
  text.replace(text.find("robot.yaml"), 10, TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml");
  const Scenario scenario = load_scenario(folder_.write(
      "heavy.yaml", text + "drives: {payload_kg: 60, harmonics: false, backlash_deg: 0.01, seed: 3}\n"));
  ASSERT_EQ(scenario.drives.drives.size(), 6U);
  for (const DriveError& drive : scenario.drives.drives) {
    EXPECT_GT(drive.compliance_rad_per_Nm, 0);
    EXPECT_EQ(drive.harmonics[0].amplitude_rad, 0);
    EXPECT_NEAR(drive.backlash_rad, 0.01 * kRadPerDeg, 1e-15);
  }
  EXPECT_EQ(scenario.drives.masses.back().mass_kg, 85) << "25 kg of its own";
}

TEST_F(ScenarioFile, ReadsPathAndFaults) {
  const Scenario scenario =
      load("stream_path:\n  - [90, -90]\nfaults:\n  - {at_ms: 2000, kind: rsi-drop, lasts_ms: 100}\n");
  ASSERT_EQ(scenario.stream_path.size(), 1U);
  EXPECT_DOUBLE_EQ(scenario.stream_path[0][0], std::numbers::pi / 2);
  ASSERT_EQ(scenario.faults.size(), 1U);
  EXPECT_EQ(scenario.faults[0].kind, ScenarioFault::Kind::RsiDrop);
  EXPECT_EQ(scenario.faults[0].at, 2000);
  EXPECT_EQ(scenario.faults[0].lasts, 100);
}

TEST_F(ScenarioFile, HasDrivesThatLagUnlessItSaysOtherwise) {
  const Scenario as_it_comes = load("");
  EXPECT_EQ(as_it_comes.dead_time_ms, 12);
  EXPECT_EQ(as_it_comes.lag_ms, std::vector{40.0});
  std::string text = kScenario;
  text.replace(
      text.find("rsi.xml"), 7,
      "rsi.xml, dead_time_ms: 100, lag_ms: [30, 60], hold_on: false, ignores_correction: true, "
      "delay: consecutive, precision: 1, source_port: 49000, timeout_cycles: 10000, arm: robot.yaml");
  const Scenario scenario = load_scenario(folder_.write("s.yaml", text));
  EXPECT_EQ(scenario.dead_time_ms, 100);
  EXPECT_EQ(scenario.lag_ms, (std::vector{30.0, 60.0}));
  EXPECT_EQ(scenario.hold_on, false);
  EXPECT_TRUE(scenario.ignores_correction);
  EXPECT_TRUE(scenario.consecutive_delay);
  EXPECT_EQ(scenario.rsi_decimals, 1);
  EXPECT_EQ(scenario.rsi_source_port, 49000);
  EXPECT_EQ(scenario.rsi_timeout_cycles, 10000);
  EXPECT_EQ(scenario.rsi_arm.value().joint_count(), 2);
}

TEST_F(ScenarioFile, DescribesATrackerThatIsWrong) {
  const Scenario scenario = load(
      "tracker: {bias_mm: {x: 1, y: 0, z: -2}, std_mm: -1, air: {temperature_c: -273}, power_lock: true}\n");
  EXPECT_EQ(scenario.bias_mm, Eigen::Vector3d(1, 0, -2));
  EXPECT_EQ(scenario.std_mm, -1);
  EXPECT_EQ(scenario.air.temperature_c, -273);
  EXPECT_EQ(scenario.air.pressure_mbar, 1013.25);
  EXPECT_TRUE(scenario.power_lock);
}

TEST_F(ScenarioFile, CountsFaultsInCyclesAndPointsAndRepeatsThem) {
  const Scenario scenario = load(
      "faults:\n"
      "  - {at_cycle: 100, kind: rsi-lose-replies, lasts_cycles: 3, every_cycles: 10}\n"
      "  - {at_point: 9, kind: tracker-bump, by_mm: {x: 5, y: 0, z: 0}}\n"
      "  - {at_ms: 10, kind: rsi-second-sender, from: 127.0.0.2, lasts_ms: 5}\n");
  const ScenarioFault& burst = scenario.faults[0];
  std::vector<int> lost;
  for (int cycle = 95; cycle < 115; ++cycle) {
    if (burst.covers(cycle)) lost.push_back(cycle);
  }
  EXPECT_EQ(lost, (std::vector{100, 101, 102, 110, 111, 112}));
  EXPECT_TRUE(burst.begins_with(110));
  EXPECT_FALSE(burst.begins_with(90));
  EXPECT_FALSE(scenario.faults[1].covers(8));
  EXPECT_TRUE(scenario.faults[1].covers(1'000'000)) << "to the end";
  EXPECT_EQ(scenario.faults[1].by_mm.x(), 5);
  EXPECT_EQ(scenario.faults[2].from, "127.0.0.2");
}

TEST_F(ScenarioFile, NamesPlaceAndPathOfEveryMistake) {
  EXPECT_EQ(error("errors:\n  - {a: 1}\n"),
            "s.yaml:6:3: errors: expected one entry for each of the 2 joints, found 1");
  EXPECT_EQ(error("errors: {seed: 1, mm: 1}\n"), "s.yaml:5:9: errors: missing key 'rad'");
  EXPECT_EQ(error("errors:\n  - {theta: 3}\n  - {}\n"),
            "s.yaml:6:13: errors[1].theta: expected -0.1..0.1, found 3");
  EXPECT_EQ(error("drives: {}\n"),
            "s.yaml:5:9: drives: known for arms of six revolute joints alone; leave it out");
  EXPECT_EQ(error("stream_path:\n  - [1, 2, 3]\n"), "s.yaml:6:5: stream_path[1]: expected 2 axes, found 3");
  EXPECT_EQ(error("stream_path:\n  - [1, 91]\n"),
            "s.yaml:6:9: stream_path[1][2]: outside the limits of joint 2");
  EXPECT_EQ(
      error("faults:\n  - {at_ms: 1, kind: fire}\n"),
      "s.yaml:6:22: faults[1].kind: expected one of beam-break, tracker-restart, tracker-bump, tracker-bias, "
      "tracker-noise, tracker-std, tracker-stray, tracker-air, tracker-busy, tracker-silent, tracker-storm, eki-drop, program-stop, program-reset, program-select, "
      "emergency-stop, gate-open, operating-mode, override, controller-restart, rsi-drop, "
      "rsi-lose-datagrams, rsi-lose-replies, "
      "rsi-duplicate, rsi-late, rsi-corrupt, rsi-reorder, rsi-silence, rsi-restart, rsi-ipoc, rsi-ignore, rsi-second-sender, "
      "found 'fire'");
  EXPECT_EQ(error("faults:\n  - {at_ms: 1}\n"), "s.yaml:6:5: faults[1]: missing key 'kind'");
  EXPECT_EQ(error("faults:\n  - {kind: beam-break}\n"),
            "s.yaml:6:5: faults[1]: missing key 'at_ms', 'at_cycle' or 'at_point'");
  EXPECT_EQ(error("faults:\n  - {kind: beam-break, at_cycle: 3}\n"),
            "s.yaml:6:34: faults[1].at_cycle: this kind of fault cannot be counted so");
  EXPECT_EQ(error("faults:\n  - {kind: rsi-drop, at_cycle: 3, lasts_ms: 4}\n"),
            "s.yaml:6:45: faults[1].lasts_ms: does not go with at_cycle");
  EXPECT_EQ(error("faults:\n  - {kind: rsi-drop, at_ms: 3, std_mm: 4}\n"),
            "s.yaml:6:40: faults[1].std_mm: does not belong to rsi-drop");
  EXPECT_EQ(error("faults:\n  - {kind: tracker-bump, at_ms: 3}\n"),
            "s.yaml:6:5: faults[1]: missing key 'by_mm'");
  EXPECT_EQ(error("tracker: {noise: {range: 1}}\n"),
            "s.yaml:5:19: tracker.noise.range: unknown key, did you mean 'range_mm'?");
}

TEST_F(ScenarioFile, RefusesAnOldNameWithTheNewOne) {
  EXPECT_EQ(error("placement: {x: 1}\n"), "s.yaml:5:1: placement: unknown key, renamed to 'robot_base'");
  EXPECT_EQ(error("warm_up: {growth_ppm: 150}\n"),
            "s.yaml:5:11: warm_up.growth_ppm: unknown key, renamed to 'expansion_ppm'");
  EXPECT_TRUE(error("faults:\n  - {kind: rsi-garble, at_cycle: 3}\n")
                  .ends_with("found 'rsi-garble', renamed to 'rsi-corrupt'"));
}

}  // namespace
}  // namespace truepose::config
