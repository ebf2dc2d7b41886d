// Planning as its users run it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "core/math/angles.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::StartsWith;

const std::string kExampleCell = TRUEPOSE_SOURCE_DIR "/config/cell.yaml";

Finished plan(std::vector<std::string> arguments, const std::string& cell = kExampleCell) {
  arguments.insert(arguments.begin(), {"plan", "--cell", cell, "--poses", "12", "--candidates", "300"});
  return run_program("truepose", arguments);
}

TEST(PlanCommand, PutsWhatThePosesAreWorthBetweenRandomOnesAndWhatNoChoiceGoesBelow) {
  const Finished done = plan({"--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.err, "") << "progress is for terminals";
  const json::object planned = printed_document(done.out).as_object();
  EXPECT_EQ(planned.at("poses").as_array().size(), 12u);
  for (const char* figure : {"rms_mm", "max_mm"}) {
    const auto of = [&](const char* set) { return planned.at(set).at(figure).as_double(); };
    EXPECT_LT(of("predicted"), of("random")) << figure;
    EXPECT_LT(of("bound"), of("predicted")) << figure;
    EXPECT_GT(of("bound"), 0) << figure;
  }
  EXPECT_LT(planned.at("travel_s").as_double(), planned.at("random_travel_s").as_double());
}

TEST(PlanCommand, WritesThePosesInTheirOrderAsOtherCommandsReadThem) {
  const TempFolder folder;
  const auto file = folder.path() / "poses.csv";
  const Finished done = plan({"--json", "--out", file.string()});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const auto written =
      config::load_joints(file, config::load_robot(TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml"));
  const json::value printed = printed_document(done.out).at("poses");
  ASSERT_EQ(written.size(), printed.as_array().size());
  for (std::size_t k = 0; k < written.size(); ++k) {
    for (Eigen::Index i = 0; i < 6; ++i) {
      EXPECT_NEAR(written[k](i) / kRadPerDeg, printed.at(k).at(static_cast<std::size_t>(i)).as_double(),
                  1e-9);
    }
  }
}

TEST(PlanCommand, RefusesAWorkspaceOutOfReachInOneLineAndWritesNothing) {
  const TempFolder folder;
  const auto cell = folder.path() / "cell.yaml";
  std::string text = text_of(kExampleCell);
  text.replace(text.find("robots/kr210"), 7, TRUEPOSE_SOURCE_DIR "/config/robots/");
  text += "workspace: {min: {x: 9000, y: 0, z: 0}, max: {x: 9500, y: 500, z: 500}}\n";
  folder.write("cell.yaml", text);
  const auto file = folder.path() / "poses.csv";
  const Finished done = plan({"--out", file.string()}, cell.string());
  EXPECT_EQ(done.exit_code, 2);
  EXPECT_EQ(done.out, "");
  EXPECT_THAT(done.err, StartsWith("truepose: " + cell.string() + ": "));
  EXPECT_EQ(std::ranges::count(done.err, '\n'), 1) << done.err;
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace truepose
