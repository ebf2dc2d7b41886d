#include "config/positioner_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/sealed_text.hpp"
#include "core/math/angles.hpp"
#include "tests/config/error_of.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;

PositionerFile example_positioner() {
  PositionerFile file{.number = 3,
                      .arm = "KR 210 R2700-2",
                      .model = "2026-01-02T03:04:05Z",
                      .X_BR = pose_from_kuka({1900.5, -350.25, 0.125}, {25, 0.5, -1})};
  file.table.name = "a \"table\"";
  file.table.created = "2026-01-03T00:00:00Z";
  file.table.cell = {
      .robot = {.name = file.table.name,
                .joints = {{.alpha_rad = 1.57, .min = -1, .max = 1, .speed = 1},
                           {.a_mm = 120.1, .alpha_rad = -1.57, .min = -3, .max = 3, .speed = 1}}},
      .base = {{1000, 2000, 30}, {0.1, 0.2, 0.3}},
      .reflectors = {{"1", {100, 200, 30}}}};
  file.table.noise = MeasurementNoise{.repeatability_mm = 0.02};
  file.table.covariance =
      Eigen::VectorXd::Constant(ParameterLayout::of(file.table.cell).size(), 1e-6).asDiagonal();
  file.workpiece.points = {{"origin", {}}, {"corner", Eigen::Vector3d(1, 2, 3)}};
  JointVector q(2);
  q << 0.1, -0.2;
  file.workpiece.readings = {{.point = 1, .q = q, .p_WS_mm = Eigen::Vector3d(1234.5678, 2, 3)}};
  return file;
}

ModelFile arm() {
  ModelFile model;
  model.name = "KR 210 R2700-2";
  model.created = "2026-01-02T03:04:05Z";
  return model;
}

TEST(PositionerFile, ReadsBackAsWhatItWas) {
  const TempFolder folder;
  const PositionerFile file = example_positioner();
  const PositionerFile back = load_positioner(folder.write("p.yaml", positioner_yaml(file)), arm());
  EXPECT_EQ(back.number, 3);
  EXPECT_LT((back.X_BR.matrix() - file.X_BR.matrix()).norm(), 1e-12);
  EXPECT_EQ(back.table.name, file.table.name);
  EXPECT_EQ(back.table.cell.robot.joints[1].a_mm, 120.1);
  EXPECT_EQ(back.table.cell.base.rxyz_rad, file.table.cell.base.rxyz_rad);
  EXPECT_EQ(back.table.covariance, file.table.covariance);
  ASSERT_EQ(back.workpiece.points.size(), 2U);
  EXPECT_EQ(back.workpiece.points[1].p_mm, file.workpiece.points[1].p_mm);
  ASSERT_EQ(back.workpiece.readings.size(), 1U);
  EXPECT_EQ(back.workpiece.readings[0].point, 1U);
  EXPECT_EQ(back.workpiece.readings[0].q, file.workpiece.readings[0].q);
  EXPECT_EQ(back.workpiece.readings[0].p_WS_mm, file.workpiece.readings[0].p_WS_mm);
  // The angles of the root are rounded on their way.
  const auto from_points = [](const std::string& text) {
    const std::size_t points = text.find("points:");
    return text.substr(points, text.rfind("sha256: ") - points);
  };
  EXPECT_EQ(from_points(positioner_yaml(back)), from_points(positioner_yaml(file)));
}

TEST(PositionerFile, OfAnotherArmOrWithOtherContentIsRefused) {
  const TempFolder folder;
  const auto error = [&](const std::string& text, const ModelFile& model) {
    const std::filesystem::path file = folder.write("p.yaml", text);
    return error_of([&] { load_positioner(file, model); }, file);
  };
  const std::string text = positioner_yaml(example_positioner());
  ModelFile other = arm();
  other.name = "KR 16";
  EXPECT_THAT(error(text, other), HasSubstr("the positioner of 'KR 210 R2700-2', but the arm is 'KR 16'"));
  ModelFile later = arm();
  later.created = "2026-05-05T00:00:00Z";
  EXPECT_THAT(error(text, later), HasSubstr("run `truepose positioner` with this model again"));

  std::string forged = text.substr(0, text.rfind("sha256: "));
  forged.replace(forged.find("120.1"), 5, "120.2");
  EXPECT_THAT(error(sealed(forged), arm()), HasSubstr("p.yaml: table: its content is not what was written"));
  EXPECT_THAT(error(sealed(text.substr(0, text.find("table: |"))), arm()), HasSubstr("missing key 'table'"));

  PositionerFile empty = example_positioner();
  empty.workpiece.readings[0].q = JointVector::Zero(1);
  EXPECT_THAT(error(positioner_yaml(empty), arm()),
              HasSubstr("expected some, each seen of one of the points at 2 joints"));
}

}  // namespace
}  // namespace truepose::config
