// Records that turn into joint angles: none is used after a change.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <functional>

#include "config/frame_file.hpp"
#include "config/model_file.hpp"
#include "config/positioner_file.hpp"
#include "config/sealed_text.hpp"
#include "core/arm/forward.hpp"
#include "tests/config/error_of.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;

ModelFile measured_arm() {
  ModelFile model;
  model.name = "KR 210 R2700-2";
  model.serial = "768034";
  model.created = "2026-01-02T03:04:05Z";
  model.cell.robot = example::kr210();
  model.cell.robot.name = model.name;
  model.cell.base = {{1000, 2000, 30}, {0.1, 0.2, 0.3}};
  model.cell.reflectors = {{"1", {100, 200, 30}}};
  model.noise = MeasurementNoise{.repeatability_mm = 0.02};
  return model;
}

/// A tool whose TCP alone the tracker read, in orientations of all kinds.
ToolFile measured_tool() {
  const ModelFile model = measured_arm();
  ToolFile file{3, model.name, model.serial, pose_from_kuka({62.5, -50.25, 190.125}, {0, 0, 0}), {}};
  file.data.points = {{kOrigin, {}}};
  Random random{7};
  for (int i = 0; i < 6; ++i) {
    const JointVector q = example::random_joints(model.cell.robot, random);
    const Eigen::Isometry3d X_WF = model.cell.base.isometry() * forward_kinematics(model.cell.robot, q);
    file.data.readings.push_back(
        {.point = 0, .q = q, .p_WS_mm = X_WF * Eigen::Vector3d(file.X_controller.translation())});
  }
  return file;
}

BaseFile measured_base() {
  const ModelFile model = measured_arm();
  BaseFile file{5, model.name, model.created, pose_from_kuka({1500, 150, 700}, {20, 3, -2})};
  for (const auto& [name, p_mm] :
       {std::pair{"origin", Eigen::Vector3d(0, 0, 0)}, std::pair{"x", Eigen::Vector3d(400, 0, 0)},
        std::pair{"xy", Eigen::Vector3d(0, 300, 0)}}) {
    file.data.readings.push_back(
        {.point = file.data.points.size(), .p_WS_mm = model.cell.base.isometry() * (file.X * p_mm)});
    file.data.points.push_back({name, {}});
  }
  return file;
}

PositionerFile measured_positioner() {
  PositionerFile file{.number = 3, .arm = measured_arm().name, .model = measured_arm().created};
  file.table = measured_arm();
  JointVector q(6);
  q << 0.1, -0.2, 0.3, 0, 0.5, 0;
  file.workpiece.points = {{kOrigin, {}}};
  file.workpiece.readings = {{.point = 0, .q = q, .p_WS_mm = Eigen::Vector3d(1234.5678, 2, 3)}};
  return file;
}

struct Record {
  std::string name, text;
  std::function<void(const std::filesystem::path&)> load;

  /// Why it is refused with this text; empty: it is not.
  std::string error(const std::string& changed) const {
    const TempFolder folder;
    const std::filesystem::path file = folder.write("r.yaml", changed);
    return error_of([&] { load(file); }, file);
  }
};

std::vector<Record> records() {
  return {{"model", model_yaml(measured_arm()), [](const auto& file) { load_model(file); }},
          {"tool", tool_yaml(measured_tool()),
           [](const auto& file) { load_tool(file, measured_arm().cell.robot); }},
          {"base", base_yaml(measured_base()), [](const auto& file) { load_base(file, measured_arm()); }},
          {"positioner", positioner_yaml(measured_positioner()),
           [](const auto& file) { load_positioner(file, measured_arm()); }}};
}

TEST(SealedRecord, OfWhichAnyDigitIsChangedIsRefused) {
  for (const Record& record : records()) {
    EXPECT_EQ(record.error(record.text), "") << record.name;
    int changed = 0;
    for (std::size_t i = 0; i < record.text.size(); ++i) {
      if (!std::isdigit(static_cast<unsigned char>(record.text[i]))) continue;
      std::string other = record.text;
      other[i] = other[i] == '9' ? '0' : static_cast<char>(other[i] + 1);
      EXPECT_NE(record.error(other), "") << record.name << ": byte " << i;
      ++changed;
    }
    EXPECT_GT(changed, 100) << record.name;
  }
}

TEST(SealedRecord, ThatGoesOnBehindItsSealOrHasNoneIsRefused) {
  for (const Record& record : records()) {
    EXPECT_NE(record.error(record.text + "# a line\n"), "") << record.name;
    if (record.name == "model") continue;  // one from before models carried a hash is judged by its points
    EXPECT_THAT(record.error(record.text.substr(0, record.text.rfind("sha256: "))),
                HasSubstr("shows that the others are unchanged"));
  }
}

TEST(SealedRecord, WhoseFrameIsNotTheOneOfItsReadingsIsRefusedThoughItsSealIsRight) {
  const TempFolder folder;
  BaseFile moved = measured_base();
  moved.X.translation().x() += 20;
  const std::filesystem::path file = folder.write("b.yaml", base_yaml(moved));
  EXPECT_THAT(
      error_of([&] { load_base(file, measured_arm()); }, file),
      HasSubstr(
          "its readings give a frame that is 20.000 mm and 0.0000 deg from the one in it (limit 0.1 mm"));

  ToolFile forged = measured_tool();
  const MeasuringCell by = *measuring_cell(measured_arm());
  ASSERT_TRUE(tool_under(by, forged)) << tool_under(by, forged).error();
  forged.X_controller.translation().x() += 20;
  const auto refused = tool_under(by, forged);
  ASSERT_FALSE(refused);
  EXPECT_EQ(
      refused.error(),
      "its readings give a frame that is 20.000 mm and 0.0000 deg from the one in it (limit 2 mm, 0.2 deg); "
      "measure the tool again");
}

}  // namespace
}  // namespace truepose::config
