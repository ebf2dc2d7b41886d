#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "config/robot_file.hpp"
#include "config/scenario.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/model_members.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {

template <>
inline constexpr int kMembers<config::CellConfig> = 20;
template <>
inline constexpr int kMembers<config::RobotConfig> = 9;
template <>
inline constexpr int kMembers<config::StreamConfig> = 15;
template <>
inline constexpr int kMembers<config::TrackerConfig> = 16;
template <>
inline constexpr int kMembers<config::ReflectorConfig> = 4;
template <>
inline constexpr int kMembers<config::CampaignConfig> = 23;
template <>
inline constexpr int kMembers<config::Iso9283Config> = 3;
template <>
inline constexpr int kMembers<config::CalibrationConfig> = 5;
template <>
inline constexpr int kMembers<config::TlsConfig> = 3;
template <>
inline constexpr int kMembers<config::ControlConfig> = 3;
template <>
inline constexpr int kMembers<config::WebConfig> = 2;
template <>
inline constexpr int kMembers<config::RecordingConfig> = 4;
template <>
inline constexpr int kMembers<config::ToolLoad> = 2;
template <>
inline constexpr int kMembers<config::Endpoint> = 2;
template <>
inline constexpr int kMembers<Surroundings> = 4;
template <>
inline constexpr int kMembers<Capsule> = 3;
template <>
inline constexpr int kMembers<BodyPart> = 2;
template <>
inline constexpr int kMembers<Box> = 2;
template <>
inline constexpr int kMembers<TestCubeRequest> = 7;

}  // namespace truepose

namespace truepose::config {

/// The example has none.
bool same(const ToolFile& a, const ToolFile& b) { return a.number == b.number; }

namespace {

using testing::ElementsAre;

const std::filesystem::path kConfig = std::filesystem::path(TRUEPOSE_SOURCE_DIR) / "config";

TEST(ShippedFiles, TheRobotStandsWhereTheControllersPosesAre) {
  const RobotModel robot = load_robot(kConfig / "robots/kr210_r2700_2.yaml");
  const auto pose = [&](double a1, double a2, double a3, double a4, double a5, double a6) {
    return forward_kinematics(robot, (JointVector(6) << a1, a2, a3, a4, a5, a6).finished() * kRadPerDeg);
  };
  const Eigen::Isometry3d home = pose(0, -90, 90, 0, 0, 0);
  EXPECT_LT((home.translation() - Eigen::Vector3d(1765, 0, 1910)).norm(), 1e-9);
  // x = -Z, y = +Y, z = +X of the base.
  const Eigen::Matrix3d at_home = (Eigen::Matrix3d() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished();
  EXPECT_TRUE(home.linear().isApprox(at_home, 1e-12));

  // What the controller shows: mm to 1e-3, A B C to 1e-3 deg.
  const Eigen::Isometry3d X = pose(20, -70, 60, 15, -40, 100);
  const Eigen::Isometry3d shown = pose_from_kuka({1932.811, -665.422, 2210.812}, {-120.897, -20.988, -37.12});
  EXPECT_LT((X.translation() - shown.translation()).norm(), 1e-3);
  EXPECT_LT(angle_between(X.linear(), shown.linear()) * kDegPerRad, 2e-3);
}

/// A key of the example cell with all that its value takes, "campaign/retries".
struct Shown {
  std::string key;
  std::size_t first, count;  ///< lines
};

std::size_t indent_of(const std::string& line) { return std::min(line.find_first_not_of(' '), line.size()); }

bool says_something(const std::string& line) {
  const std::size_t begin = indent_of(line);
  return begin < line.size() && line[begin] != '#';
}

/// Every key that is not a section.
std::vector<Shown> keys_shown(const std::vector<std::string>& lines) {
  std::vector<Shown> all;
  std::string section;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    const std::size_t indent = indent_of(line);
    if (!says_something(line) || indent > 2) continue;
    const std::string key = line.substr(indent, line.find(':') - indent);
    std::size_t end = i + 1;
    while (end < lines.size() && says_something(lines[end]) && indent_of(lines[end]) > indent) ++end;
    const std::size_t value = line.find_first_not_of(' ', line.find(':') + 1);
    const bool is_section = indent == 0 && (value == std::string::npos || line[value] == '#');
    if (is_section) section = key + "/";
    if (!is_section) all.push_back({(indent == 0 ? "" : section) + key, i, end - i});
  }
  return all;
}

/// The example, and itself without any one of its keys.
class ExampleCell {
 public:
  ExampleCell() {
    for (const char* folder : {"kuka", "robots"})
      std::filesystem::create_directory_symlink(kConfig / folder, folder_.path() / folder);
    std::ifstream file{kConfig / "cell.yaml"};
    for (std::string line; std::getline(file, line);) lines_.push_back(line);
  }

  const std::vector<std::string>& lines() const { return lines_; }
  CellConfig without(const Shown& key) const {
    std::string text;
    for (std::size_t i = 0; i < lines_.size(); ++i)
      if (i < key.first || i >= key.first + key.count) text += lines_[i] + "\n";
    return load_cell(folder_.write("cell.yaml", text));
  }
  CellConfig whole() const { return without({}); }

 private:
  TempFolder folder_;
  std::vector<std::string> lines_;
};

TEST(ShippedFiles, TheExampleCellShowsTheDefaultOfEveryKeyThatMayBeLeftOut) {
  const ExampleCell example;
  const CellConfig whole = example.whole();
  std::vector<std::string> must_be_given, shows_another;
  for (const Shown& shown : keys_shown(example.lines())) try {
      if (!truepose::same(example.without(shown), whole)) shows_another.push_back(shown.key);
    } catch (const ConfigError&) {
      must_be_given.push_back(shown.key);
    }
  EXPECT_THAT(must_be_given,
              ElementsAre("name", "robot/file", "robot/eki_motion", "robot/eki_state", "stream/listen",
                          "stream/ethernet_xml", "tracker/address", "control/token_file", "store"));
  // What the head of the file names as exceptions, and the two names of which it says what leaving them out
  // means.
  EXPECT_THAT(shows_another, ElementsAre("robot/expect_model", "tracker/reflector", "tracker/robot_base",
                                         "reflector/offset_mm", "reflector/facing", "surroundings/tool"));
}

TEST(ShippedFiles, TheDemoScenarioIsTheArmOfThePaperNearTheExampleCellsGuess) {
  const CellConfig cell = load_cell(kConfig / "cell.yaml");
  const Scenario scenario = load_scenario(kConfig / "scenarios/demo.yaml");
  EXPECT_DOUBLE_EQ(scenario.truth.joints[1].a_mm, 330.63);
  EXPECT_DOUBLE_EQ(scenario.truth.joints[2].beta_rad, 0.001);
  EXPECT_NEAR(scenario.X_WB.translation().norm(), 3640, 10);
  EXPECT_EQ(scenario.ethernet_xml, cell.stream.ethernet_xml);
  EXPECT_TRUE(std::filesystem::exists(cell.stream.ethernet_xml));
  EXPECT_NE(scenario.robot_model.find(cell.robot.expect_model), std::string::npos);

  // The first search must find the reflector wherever the path leads.
  for (const JointVector& q : scenario.stream_path) {
    const Eigen::Vector3d guess =
        cell.tracker.robot_base * (forward_kinematics(cell.robot.model, q) * cell.reflector.p_FS_mm);
    const Eigen::Vector3d truth = scenario.X_WB * (forward_kinematics(scenario.truth, q) * scenario.p_FS_mm);
    EXPECT_LT((guess - truth).norm(), cell.tracker.first_search_radius_mm);
    EXPECT_GT((guess - truth).norm(), cell.tracker.search_radius_mm);
  }
}

}  // namespace
}  // namespace truepose::config
