// A document that is given where another is asked for is refused by what it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "config/cell_config.hpp"
#include "config/frame_file.hpp"
#include "config/import/opw_file.hpp"
#include "config/model_file.hpp"
#include "config/positioner_file.hpp"
#include "config/robot_file.hpp"
#include "config/scenario.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

const std::filesystem::path kShipped = std::filesystem::path(TRUEPOSE_SOURCE_DIR) / "config";

ModelFile model() {
  return {.name = "arm",
          .created = "2026-01-02T03:04:05Z",
          .cell = {.robot = load_robot(kShipped / "robots/kr210_r2700_2.yaml"), .reflectors = {{"1", {}}}}};
}

PositionerFile positioner() {
  return {.arm = "arm",
          .table = model(),
          .workpiece = {.points = {{"origin", {}}}, .readings = {{.q = JointVector::Zero(6)}}}};
}

struct Document {
  std::string name, text;
};

/// A reading of a point.
FrameReadings seen() {
  return {{{kOrigin, Eigen::Vector3d(1234.5678, 2345.6789, 3456.7891)}},
          {{.point = 0, .q = JointVector::Constant(6, 0.123456789), .p_WS_mm = Eigen::Vector3d(1, 2, 3)}}};
}

std::vector<Document> documents() {
  return {
      {"a robot file", read_text_file(kShipped / "robots/kr210_r2700_2.yaml")},
      {"a model", model_yaml(model())},
      {"a tool of `truepose tool --out`", tool_yaml({.arm = "arm", .data = seen()})},
      {"a base of `truepose base --out`", base_yaml({.arm = "arm", .data = seen()})},
      {"a positioner of `truepose positioner --out`", positioner_yaml(positioner())},
      {"a cell file", read_text_file(kShipped / "cell.yaml")},
      {"a scenario of the simulator", read_text_file(kShipped / "scenarios/demo.yaml")},
      {"OPW parameters", "opw_kinematics_geometric_parameters: {a1: 0.1}\n"},
      {"the JSON document of a calibration", R"({"rank": 27, "identify": {}, "parameters": []})"},
      {"the JSON document of a tool or base", R"({"kind": "tool", "frame": {}, "sigma_mm": 1, "krl": ""})"},
      {"the JSON document of a plan", R"({"poses": [], "predicted": {}, "random": {}, "bound": {}})"},
      {"a table (CSV)", "q1,q2,q3\n1,2,3\n4,5,6\n"}};
}

struct Reader {
  std::string name;
  std::function<void(const std::filesystem::path&)> load;
};

std::vector<Reader> readers() {
  return {{"a robot file", load_robot},
          {"a model", load_model},
          {"a tool of `truepose tool --out`", [](const auto& file) { load_tool(file, model().cell.robot); }},
          {"a base of `truepose base --out`", [](const auto& file) { load_base(file, model()); }},
          {"a positioner of `truepose positioner --out`",
           [](const auto& file) { load_positioner(file, model()); }},
          {"a cell file", load_cell},
          {"OPW parameters", load_opw},
          {"a scenario of the simulator", load_scenario}};
}

TEST(DocumentOfAnotherKind, IsRefusedByWhatItIsAndWhatIsAsked) {
  const TempFolder folder;
  for (const Document& document : documents()) {
    const std::filesystem::path file = folder.write("file", document.text);
    for (const Reader& reader : readers()) {
      const std::string error = error_of([&] { reader.load(file); }, file);
      const std::string refused = ": is " + document.name + ", not " + reader.name;
      EXPECT_THAT(error, document.name == reader.name ? testing::Matcher<std::string>(Not(HasSubstr(": is ")))
                                                      : EndsWith(refused));
    }
  }
}

TEST(DocumentOfAnotherKind, IsNotWhatHasASlipOfTheFinger) {
  const TempFolder folder;
  const std::filesystem::path file = folder.write("file", "name: r\njoint: []\n");
  EXPECT_EQ(error_of([&] { load_robot(file); }, file),
            "file:2:1: joint: unknown key, did you mean 'joints'?");
}

}  // namespace
}  // namespace truepose::config
