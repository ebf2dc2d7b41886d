#include "config/path_file.hpp"

#include <gtest/gtest.h>

#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

const std::string kPathHeader =
    "time_s,program,point,gain_percent,flange_x_mm,flange_y_mm,flange_z_mm,flange_a_deg,flange_b_deg,flange_c_deg,"
    "with_x_mm,with_y_mm,with_z_mm,without_x_mm,without_y_mm,without_z_mm\n";
const std::string kPlaces = ",1,2,3,4,5,6,7,8,9,1,2,3\n";

class PathFile : public testing::Test {
 protected:
  ProductionPath load(const std::string& text) {
    return load_production_path(folder_.write("path.csv", text), {X_WB_, {10, 0, 0}, two_joints()});
  }
  /// Of a file of these rows.
  std::string error(const std::string& rows) {
    return error_of([&] { load(kPathHeader + rows); }, folder_.path() / "path.csv");
  }
  static RobotModel two_joints() {
    RobotModel arm;
    arm.joints.resize(2);
    return arm;
  }

  TempFolder folder_;
  Eigen::Isometry3d X_WB_ = Eigen::Isometry3d::Identity();
};

TEST_F(PathFile, BringsSamplesAndPointsInAnyOrderOfColumnsIntoTheBase) {
  X_WB_.translation() = Eigen::Vector3d(1000, 0, 0);
  X_WB_.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // the base's x is the tracker's y
  const ProductionPath path = load(
      "program,time_s,gain_percent,point,with_x_mm,with_y_mm,with_z_mm,without_x_mm,without_y_mm,without_z_mm,"
      "flange_x_mm,flange_y_mm,flange_z_mm,flange_a_deg,flange_b_deg,flange_c_deg\n"
      "GLUING,12.040,57,0,995,4,6,1000,0,0,4,5,6,0,0,0\n"
      "GLUING,12.040,-2,1,0,0,0,0,0,9.5,4,5,6,90,0,0\n");
  EXPECT_EQ(path.program, "GLUING");
  ASSERT_EQ(path.samples.size(), 2U);
  EXPECT_EQ(path.samples[0].time_s, 12.04);
  EXPECT_EQ(path.samples[0].gain_percent, 57);
  EXPECT_FALSE(path.samples[0].at_point);
  EXPECT_TRUE(path.samples[0].wanted_mm.isApprox(Eigen::Vector3d(14, 5, 6)));
  EXPECT_TRUE(path.samples[0].with_mm.isApprox(Eigen::Vector3d(4, 5, 6)));
  EXPECT_TRUE(path.samples[0].without_mm.isZero());
  EXPECT_TRUE(path.samples[1].at_point);
  EXPECT_EQ(path.samples[1].gain_percent, -2);
  EXPECT_TRUE(path.samples[1].wanted_mm.isApprox(Eigen::Vector3d(4, 15, 6)))
      << "the flange is turned about z";
  EXPECT_TRUE(path.samples[1].without_mm.isApprox(Eigen::Vector3d(0, 1000, 9.5)));
}

TEST_F(PathFile, NamesAllProgramsOnce) {
  EXPECT_EQ(
      load(kPathHeader + "1,GLUE,0,0" + kPlaces + "2,WIPE,0,0" + kPlaces + "3,GLUE,0,0" + kPlaces).program,
      "GLUE, WIPE");
  std::string many;
  for (int i = 0; i <= 20; ++i) many += "1,P" + std::to_string(i) + ",0,0" + kPlaces;
  EXPECT_EQ(error(many), "path.csv: row 21 (line 22): program: more than 20 programs in one file");
}

TEST_F(PathFile, WithoutAxesHasNoLag) {
  const ProductionPath path = load(kPathHeader + "1,GLUE,0,100" + kPlaces);
  EXPECT_FALSE(path.lag);
  EXPECT_FALSE(path.samples[0].lagged_mm);
}

TEST_F(PathFile, WithAxesHasThemOfEveryJoint) {
  std::string header = kPathHeader;
  header.insert(header.size() - 1,
                ",set_a1_deg,set_a2_deg,correction_a1_deg,correction_a2_deg,actual_a1_deg");
  const auto load_it = [&](const std::string& text) {
    return error_of([&] { load(text); }, folder_.path() / "path.csv");
  };
  EXPECT_EQ(load_it(header + "1,GLUE,0,100,1,2,3,4,5,6,7,8,9,1,2,3,0,0,0,0,0\n"),
            "path.csv: missing column 'actual_a2_deg'");
  header.insert(header.size() - 1, ",actual_a2_deg");
  EXPECT_EQ(load_it(header + "1,GLUE,0,100,1,2,3,4,5,6,7,8,9,1,2,3,0,0,0,0,0,3601\n"),
            "path.csv: row 1 (line 2): actual_a2_deg: expected -3600..3600, found '3601'");
}

TEST_F(PathFile, ErrorsNameTheRow) {
  const std::string good = "1.5,GLUING,0,100" + kPlaces;
  EXPECT_EQ(error(""), "path.csv: no rows of data");
  EXPECT_EQ(error(good + "1.4,GLUING,0,100" + kPlaces),
            "path.csv: row 2 (line 3): time_s: expected no time before that of the row above, found '1.4'");
  EXPECT_EQ(error(good + "2,,0,100" + kPlaces),
            "path.csv: row 2 (line 3): program: missing, expected a name");
  EXPECT_EQ(error(good + "2,GLUING,yes,100" + kPlaces),
            "path.csv: row 2 (line 3): point: expected 0 or 1, found 'yes'");
  EXPECT_EQ(error(good + "2,GLUING,0,101" + kPlaces),
            "path.csv: row 2 (line 3): gain_percent: expected 100 at most, found '101'");
  EXPECT_EQ(error(good + "2,GLUING,0,100,1,2,3,4,5,6,7,nan,9,1,2,3\n"),
            "path.csv: row 2 (line 3): with_y_mm: not a finite number: 'nan'");
  EXPECT_EQ(error(good + "2,GLUING,0,100,1,2,3,4,5,6,7,8,9,1,2,-1e6\n"),
            "path.csv: row 2 (line 3): without_z_mm: expected -100000..100000, found '-1e6'");
  EXPECT_EQ(error(good + "2,GLUING,0,100,1,2,3,4,361,6,7,8,9,1,2,3\n"),
            "path.csv: row 2 (line 3): flange_b_deg: expected -360..360, found '361'");
  EXPECT_EQ(error(good + "2,GLUING,0,100,1,2\n"),
            "path.csv: row 2 (line 3): flange_z_mm: missing, the row ends before it");
  EXPECT_EQ(error_of([&] { load("time_s,program\n1,GLUING\n"); }, folder_.path() / "path.csv"),
            "path.csv: missing column 'point'");
}

TEST_F(PathFile, RefusesMoreThanAReportCanCarry) {
  std::string rows;
  for (int i = 0; i <= 60'000; ++i) rows += "1,P,0,0" + kPlaces;
  EXPECT_EQ(error(rows), "path.csv: more than 60000 rows of data, 20 minutes: record a shorter time");
}

}  // namespace
}  // namespace truepose::config
