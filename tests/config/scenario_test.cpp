#include "config/scenario.hpp"

#include <gtest/gtest.h>

#include "core/kinematics/angles.hpp"
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
    "placement: {x: 1, y: 2, z: 3, a: 0, b: 0, c: 0}\n"
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

TEST_F(ScenarioFile, DescribesWhatTheJointsDoBesides) {
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
  EXPECT_EQ(scenario.faults[0].kind, "rsi-drop");
  EXPECT_EQ(scenario.faults[0].lasts, std::chrono::milliseconds(100));
}

TEST_F(ScenarioFile, NamesPlaceAndPathOfEveryMistake) {
  EXPECT_EQ(error("errors:\n  - {a: 1}\n"),
            "s.yaml:6:3: errors: expected one entry for each of the 2 joints, found 1");
  EXPECT_EQ(error("errors: {seed: 1, mm: 1}\n"), "s.yaml:5:9: errors: missing key 'rad'");
  EXPECT_EQ(error("errors:\n  - {theta: 3}\n  - {}\n"),
            "s.yaml:6:13: errors[1].theta: expected -0.1..0.1, found 3");
  EXPECT_EQ(error("drives: {}\n"), "s.yaml:5:9: drives: known for arms of six revolute joints alone; leave it out");
  EXPECT_EQ(error("stream_path:\n  - [1, 2, 3]\n"), "s.yaml:6:5: stream_path[1]: expected 2 axes, found 3");
  EXPECT_EQ(error("stream_path:\n  - [1, 91]\n"),
            "s.yaml:6:9: stream_path[1][2]: outside the limits of joint 2");
  EXPECT_EQ(error("faults:\n  - {at_ms: 1, kind: fire}\n"),
            "s.yaml:6:22: faults[1].kind: expected one of beam-break, tracker-restart, eki-drop, rsi-drop, "
            "found 'fire'");
  EXPECT_EQ(error("faults:\n  - {at_ms: 1}\n"), "s.yaml:6:5: faults[1]: missing key 'kind'");
  EXPECT_EQ(error("tracker: {noise: {range: 1}}\n"),
            "s.yaml:5:19: tracker.noise.range: unknown key, did you mean 'range_mm'?");
}

}  // namespace
}  // namespace truepose::config
