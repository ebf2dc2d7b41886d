#include "config/test_cycle_file.hpp"

#include <gtest/gtest.h>

#include "core/math/angles.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

class TestCycleFile : public testing::Test {
 protected:
  std::vector<TestPoint> load(const std::string& data, const std::string& targets = "") {
    return load_test_cycles(folder_.write("data.csv", data), targets.empty()
                                                                 ? std::filesystem::path()
                                                                 : folder_.write("targets.csv", targets));
  }
  std::string error(const std::string& data, const std::string& targets = "") {
    return error_of([&] { load(data, targets); }, folder_.path() / "data.csv");
  }
  TempFolder folder_;
};

TEST_F(TestCycleFile, ReadsPointsInAnyOrderOfColumnsAndRows) {
  const auto points = load(
      "cycle,z,y,x,point,direction,time\n"
      "1,6,5,4,P2,,\n"
      "1,3,2,1,P1,+x,0 min\n"
      "2,3,2,1.5,P1,+x,60 min\n",
      "point,x,y,z\nP2,4,5,6.5\nP1,1,2,3\nP3,0,0,0\n");
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[2].name, "P3");
  EXPECT_TRUE(points[2].attained.empty()) << "no cycle came there";
  EXPECT_EQ(points[0].name, "P1");
  EXPECT_EQ(points[0].commanded.p_mm, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(points[0].attained.size(), 2U);
  EXPECT_EQ(points[0].attained[1].pose.p_mm, Eigen::Vector3d(1.5, 2, 3));
  EXPECT_EQ(points[0].attained[1].direction, "+x");
  EXPECT_EQ(points[0].attained[1].series, "60 min");
  EXPECT_FALSE(points[0].attained[0].pose.R);
}

TEST_F(TestCycleFile, NamesNoSeriesWhereThereIsOneAlone) {
  const auto points = load("point,cycle,x,y,z,cx,cy,cz,time\nP1,1,1,2,3,1,2,3,now\nP1,2,1,2,3,1,2,3,now\n");
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].attained[1].series, "");
}

TEST_F(TestCycleFile, ReadsCommandedPosesFromTheDataToo) {
  const auto points = load(
      "point,cycle,x,y,z,a,b,c,cx,cy,cz,ca,cb,cc\n"
      "P1,1,1,2,3,10,90,0,1,2,2,10,89,0\n"
      "P1,2,1,2,3,10,90,0,1,2,2,10,89,0\n");
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].commanded.p_mm, Eigen::Vector3d(1, 2, 2));
  ASSERT_TRUE(points[0].commanded.R && points[0].attained[0].pose.R);
  EXPECT_NEAR(angle_between(*points[0].commanded.R, *points[0].attained[0].pose.R), kRadPerDeg, 1e-9);
}

TEST_F(TestCycleFile, MakesOnePoseOfSeveralReflectors) {
  const Eigen::Isometry3d X = pose_from_kuka({0.1, -0.2, 0.3}, {0.5, 0, 0});
  std::string data = "point,cycle,smr,x,y,z\n", targets = "point,smr,x,y,z\n";
  for (const auto& [name, p] : {std::pair{"a", Eigen::Vector3d(1000, 0, 500)},
                                {"b", Eigen::Vector3d(1100, 0, 500)},
                                {"c", Eigen::Vector3d(1000, 80, 500)}}) {
    const Eigen::Vector3d m = X * p;
    const auto row = [](const Eigen::Vector3d& v) {
      return std::to_string(v.x()) + "," + std::to_string(v.y()) + "," + std::to_string(v.z()) + "\n";
    };
    targets += "P1," + std::string(name) + "," + row(p);
    data += "P1,1," + std::string(name) + "," + row(m);
  }
  const auto points = load(data, targets);
  ASSERT_EQ(points.size(), 1U);
  const TestPose& attained = points[0].attained[0].pose;
  ASSERT_TRUE(attained.R && points[0].commanded.R);
  EXPECT_NEAR(angle_between(*points[0].commanded.R, *attained.R) * kDegPerRad, 0.5, 1e-6);
  EXPECT_LT((attained.p_mm - X * points[0].commanded.p_mm).norm(), 1e-5);

  EXPECT_EQ(error(data.substr(0, data.rfind("P1")), targets),
            "data.csv: row 1 (line 2): point: cycle 1 of P1 lacks reflector 'c'");
  EXPECT_EQ(error(data + "P1,1,d,1,2,3\n", targets),
            "data.csv: row 1 (line 2): point: no commanded pose of P1 for reflector 'd'");
}

TEST_F(TestCycleFile, ErrorsNameTheRow) {
  EXPECT_EQ(error("point,cycle,x,y,z\nP1,1,1,2,3\n"),
            "data.csv: no commanded poses: give them as columns cx,cy,cz or in a file of their own");
  EXPECT_EQ(error("point,cycle,x,y,z\nP1,1,1,2,3\nP9,1,1,2,3\n", "point,x,y,z\nP1,1,2,3\n"),
            "data.csv: row 2 (line 3): point: no commanded pose of P9");
  EXPECT_EQ(error("point,cycle,x,y,z\nP1,1,1,2,3\nP1,1,1,2,3\n", "point,x,y,z\nP1,1,2,3\n"),
            "data.csv: row 2 (line 3): cycle: cycle 1 of P1 is there twice");
  EXPECT_EQ(error("point,cycle,x,y,z\nP1,1,1,two,3\n", "point,x,y,z\nP1,1,2,3\n"),
            "data.csv: row 1 (line 2): y: not a number: 'two'");
  EXPECT_EQ(error("point,cycle,x,y,z\n,1,1,2,3\n", "point,x,y,z\nP1,1,2,3\n"),
            "data.csv: row 1 (line 2): point: missing, expected a name");
  EXPECT_EQ(error("point,cycle,x,y,z,a\nP1,1,1,2,3,4\n", "point,x,y,z\nP1,1,2,3\n"),
            "data.csv: missing column 'b'");
  EXPECT_EQ(error("point,cycle,x,y,z\nP1,1,1,2,3\n", "point,x,y,z\nP1,1,2,3\nP1,1,2,3\n"),
            "targets.csv: row 2 (line 3): point: P1 is there twice");
  EXPECT_EQ(error("point,cycle,x,y,z,cx,cy,cz\nP1,1,1,2,3,1,2,3\nP1,2,1,2,3,1,2,4\n"),
            "data.csv: row 2 (line 3): point: another row of P1 commands another pose");
}

}  // namespace
}  // namespace truepose::config
