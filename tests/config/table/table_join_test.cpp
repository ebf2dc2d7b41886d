#include "config/table/table_join.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>

#include "config/measurement_file.hpp"
#include "config/table/table_reading.hpp"
#include "tests/config/error_of.hpp"
#include "tests/config/table/sheet.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;

/// Joints and points of the correct sheet in two files.
class TwoFilesOfMeasurements : public testing::Test {
 protected:
  using NameOfRow = std::function<std::string(std::size_t)>;

  static Sheet part(std::ptrdiff_t first, std::ptrdiff_t end, const std::string& key, const NameOfRow& name) {
    const Sheet whole = Sheet::correct();
    Sheet sheet{plus({key}, {whole.header.begin() + first, whole.header.begin() + end}), {}};
    for (std::size_t row = 0; row < whole.rows.size(); ++row)
      sheet.rows.push_back(
          plus({name(row)}, {whole.rows[row].begin() + first, whole.rows[row].begin() + end}));
    return sheet;
  }
  std::string two_files(const std::string& joints, const std::string& points) {
    return folder_.write("joints.csv", joints).string() + "+" + folder_.write("points.csv", points).string();
  }
  void expect_joined(const std::string& joints, const std::string& points) {
    said_.clear();
    const TableReading reading{.report = [this](const std::string& line) { said_ += line + "\n"; }};
    MeasurementData data;
    ASSERT_NO_THROW(data = load_measurements(two_files(joints, points), robot_, &reading))
        << refused(joints, points);
    const auto plain = load_measurements(folder_.write("plain.csv", Sheet::correct().text()), robot_);
    ASSERT_EQ(data.points.size(), plain.points.size());
    for (std::size_t k = 0; k < plain.points.size(); ++k) {
      EXPECT_EQ(data.points[k].q, plain.points[k].q);
      EXPECT_EQ(data.points[k].p_WS_mm, plain.points[k].p_WS_mm);
    }
  }
  std::string refused(const std::string& joints, const std::string& points) {
    const TableReading reading;
    return error_of([&] { load_measurements(two_files(joints, points), robot_, &reading); },
                    folder_.path() / "joints.csv");
  }
  static std::string p(std::size_t row) { return "p" + std::to_string(row + 1); }
  static std::string n(std::size_t row) { return std::to_string(row + 1); }

  TempFolder folder_;
  RobotModel robot_ = example::kr210();
  std::string said_;
};

TEST_F(TwoFilesOfMeasurements, AreJoinedByNameNumberOrTimeInAnyOrder) {
  Sheet shuffled = part(0, 6, "point", p);
  std::ranges::reverse(shuffled.rows);
  expect_joined(shuffled.text(), part(6, 9, "point", p).text());
  EXPECT_THAT(said_, HasSubstr("points.csv by 'point': 12 joined"));
  expect_joined(shuffled.with_decimal_commas().text(";"), part(6, 9, "Point Name", p).text("\t"));
  EXPECT_THAT(said_, HasSubstr("points.csv: read as: tabs; rows named by 'Point Name'\n"));
  EXPECT_THAT(said_, testing::Not(HasSubstr("key:")));
  expect_joined(part(0, 6, "Nr", n).text(), part(6, 9, "Name", p).text());
  const auto time = [](std::size_t row) { return formatted("2026-11-26T08:%02zu:30", row); };
  expect_joined(part(0, 6, "time", time).text(), part(6, 9, "time", time).text());
}

TEST_F(TwoFilesOfMeasurements, MayBeGivenInEitherOrder) {
  expect_joined(part(6, 9, "point", p).text(), part(0, 6, "point", p).text());
  EXPECT_THAT(said_, HasSubstr("joints of " + (folder_.path() / "points.csv").string() + " by 'point'"));
}

TEST_F(TwoFilesOfMeasurements, PointsAreThoseOfSpatialAnalyzerAndPolyWorksToo) {
  const auto collection = [](std::size_t row) { return "A::CAL::p" + std::to_string(row + 1); };
  const auto stamp = [](std::size_t row) { return formatted("11/27/2026 8:00:%02zu AM", row); };
  const Sheet exported =
      part(6, 9, "Collection::Group::Point", collection).with_column(4, "Time Stamp", stamp);
  expect_joined(part(0, 6, "point", p).text(), exported.text(", "));
  expect_joined(part(0, 6, "Nr", n).with_decimal_commas().text(";"), exported.text(", "));
  const Sheet polyworks = part(6, 9, "Name", p).with_header({"Name", "X", "Y", "Z"});
  expect_joined(part(0, 6, "name", p).text(), "# PolyWorks, mm\n" + polyworks.text("\t"));
}

TEST_F(TwoFilesOfMeasurements, AreJoinedByPosesThatHaveNames) {
  expect_joined(part(0, 6, "Pose", p).text(), part(6, 9, "Pose", p).text());
}

TEST_F(TwoFilesOfMeasurements, MayBothHaveJoints) {
  expect_joined(part(0, 6, "point", p).text(), part(0, 9, "point", p).text());
  EXPECT_THAT(refused(part(0, 6, "remark", p).text(), part(0, 9, "remark", p).text()),
              HasSubstr("no column joins the two files"));
}

TEST_F(TwoFilesOfMeasurements, WithoutAColumnThatJoinsThemAreRefused) {
  const std::string joints = part(0, 6, "point", p).text(), points = part(6, 9, "point", p).text();
  const auto expect_not_joined = [&](const std::string& a, const std::string& b) {
    EXPECT_THAT(refused(a, b), HasSubstr("no column joins the two files"));
  };
  expect_not_joined(part(0, 6, "remark", p).text(), part(6, 9, "remark", p).text());
  expect_not_joined(joints,
                    part(6, 9, "point", [](std::size_t row) { return std::string(row + 1, 'x'); }).text());
  expect_not_joined(part(0, 6, "point", [](std::size_t) { return "p"; }).text(), points);
  const auto shifted = [](std::size_t row) { return std::to_string((row + 1) % 12 + 1); };
  EXPECT_THAT(refused(part(0, 6, "point", p).with_column(1, "Nr", n).text(),
                      part(6, 9, "point", p).with_column(1, "Nr", shifted).text()),
              HasSubstr("join the rows differently: remove one of the columns"));
}

}  // namespace
}  // namespace truepose::config
