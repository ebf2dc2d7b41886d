#include "config/measurement_file.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "config/number_text.hpp"
#include "core/math/angles.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

/// A revolute joint on a rail.
RobotModel rail_and_axis() {
  RobotModel robot;
  robot.joints.resize(2);
  robot.joints[0].type = JointType::Prismatic;
  return robot;
}

class MeasurementFile : public testing::Test {
 protected:
  MeasurementData load(const std::string& text) {
    return load_measurements(folder_.write("data.csv", text), robot_);
  }
  std::string error(const std::string& text) {
    const auto file = folder_.write("data.csv", text);
    return error_of([&] { load_measurements(file, robot_); }, file);
  }
  TempFolder folder_;
  RobotModel robot_ = rail_and_axis();
};

TEST_F(MeasurementFile, ReadsColumnsInAnyOrderAndConvertsDegreesButNoRail) {
  const MeasurementData data = load("x,q2,q1,z,y\n1,180,250,3,2\n-1,90,0,-3e2,+2\n");
  ASSERT_EQ(data.points.size(), 2U);
  EXPECT_EQ(data.points[0].q, (JointVector(2) << 250, std::numbers::pi).finished());
  EXPECT_EQ(data.points[0].p_WS_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(data.points[1].p_WS_mm, Eigen::Vector3d(-1, 2, -300));
  EXPECT_EQ(data.points[1].row, 2);
  EXPECT_EQ(data.smr_names, std::vector<std::string>{"1"});
  EXPECT_EQ(data.points[0].set, PoseSet::Identify);
  EXPECT_FALSE(data.points[0].sigma_mm);
  EXPECT_TRUE(data.points[0].direction.empty());
}

TEST_F(MeasurementFile, ReadsEveryOptionalColumn) {
  const MeasurementData data = load(
      "q1,q2,x,y,z,smr,set,sigma,dir1,dir2,time,temp1,temp2\n"
      "1,2,3,4,5,left,validate,0.012,-1,1,2026-01-02T03:04:05Z,31.5,28\n"
      "1,2,3,4,5,\"right, upper\",identify,,,,2026-01-02T03:04:35Z,,\n"
      "1,2,3,4,5,left,identify,0.5,0,0,2026-01-02T03:05:05Z,20,20\n");
  EXPECT_EQ(data.points[0].temperature_c, (std::vector<double>{31.5, 28}));
  EXPECT_TRUE(data.points[1].temperature_c.empty());
  EXPECT_EQ(data.smr_names, (std::vector<std::string>{"left", "right, upper"}));
  EXPECT_EQ(data.points[0].set, PoseSet::Validate);
  EXPECT_EQ(data.points[0].sigma_mm, 0.012);
  EXPECT_EQ(data.points[0].direction, (std::vector<std::int8_t>{-1, 1}));
  EXPECT_EQ(data.points[0].time, "2026-01-02T03:04:05Z");
  EXPECT_EQ(data.points[1].smr, 1);
  EXPECT_FALSE(data.points[1].sigma_mm);
  EXPECT_TRUE(data.points[1].direction.empty());
  EXPECT_EQ(data.points[2].smr, 0);
}

TEST_F(MeasurementFile, ReadsWhatTheFlangeCarriedAndWritesItBack) {
  const MeasurementData data =
      load("q1,q2,x,y,z,payload_kg,payload_x,payload_y,payload_z\n1,2,3,4,5,60,10,-20,180\n1,2,3,4,5,,,,\n");
  EXPECT_EQ(data.points[0].payload, (LinkMass{60, {10, -20, 180}}));
  EXPECT_FALSE(data.points[1].payload) << "what the arm carries";
  std::ostringstream out;
  write_measurements(out, data, robot_);
  const MeasurementData again = load(out.str());
  EXPECT_EQ(again.points[0].payload, data.points[0].payload);
  EXPECT_FALSE(again.points[1].payload);
}

TEST_F(MeasurementFile, ReadsHowA6DTargetIsTurnedAndWritesItBack) {
  const MeasurementData data =
      load("q1,q2,x,y,z,a,b,c,sigma_abc\n1,2,3,4,5,90,0,0,0.01\n1,2,3,4,5,10,-20,170.5,0.5\n1,2,3,4,5,,,,\n");
  ASSERT_TRUE(data.points[0].orientation && data.points[1].orientation);
  const Eigen::Vector3d x_of_target = data.points[0].orientation->R_WT.col(0);
  EXPECT_LT((x_of_target - Eigen::Vector3d::UnitY()).norm(), 1e-15) << "A turns about the tracker's z";
  EXPECT_DOUBLE_EQ(data.points[0].orientation->sigma_rad, 0.01 * kRadPerDeg);
  EXPECT_FALSE(data.points[2].orientation) << "a reflector";
  std::ostringstream out;
  write_measurements(out, data, robot_);
  const MeasurementData again = load(out.str());
  for (const std::size_t i : {0U, 1U}) {
    ASSERT_TRUE(again.points[i].orientation) << out.str();
    EXPECT_LT(angle_between(again.points[i].orientation->R_WT, data.points[i].orientation->R_WT), 1e-14);
    EXPECT_DOUBLE_EQ(again.points[i].orientation->sigma_rad, data.points[i].orientation->sigma_rad);
  }
  EXPECT_FALSE(again.points[2].orientation);
}

TEST_F(MeasurementFile, TakesNoExcessAsNoneAndWritesWhatThereIs) {
  const MeasurementData data = load("q1,q2,x,y,z,excess\n1,2,3,4,5,0\n1,2,3,4,5,\n1,2,3,4,5,0.03\n");
  EXPECT_EQ(data.points[0].excess_mm, 0);
  EXPECT_EQ(data.points[1].excess_mm, 0);
  EXPECT_EQ(data.points[2].excess_mm, 0.03);
  std::ostringstream out;
  write_measurements(out, data, robot_);
  EXPECT_EQ(load(out.str()).points[2].excess_mm, 0.03) << out.str();
  EXPECT_EQ(error("q1,q2,x,y,z,excess\n1,2,3,4,5,-0.1\n"),
            "data.csv: row 1 (line 2): excess: expected 0 to 1000 mm, found -0.1");
  EXPECT_EQ(error("q1,q2,x,y,z,excess\n1,2,3,4,5,1001\n"),
            "data.csv: row 1 (line 2): excess: expected 0 to 1000 mm, found 1001");
}

TEST_F(MeasurementFile, AcceptsAByteOrderMarkCarriageReturnsBlankLinesAndNoLastLineEnd) {
  const MeasurementData data = load("\xEF\xBB\xBFq1,q2,x,y,z\r\n\r\n1,2,3,4,5\r\n 6 ,7,8,9,10");
  ASSERT_EQ(data.points.size(), 2U);
  EXPECT_EQ(data.points[1].q[0], 6);
  EXPECT_EQ(data.points[1].p_WS_mm.z(), 10);
}

TEST_F(MeasurementFile, NamesAMissingAnUnknownOrADuplicateColumn) {
  EXPECT_EQ(error("q1,x,y,z\n1,2,3,4\n"), "data.csv: missing column 'q2'");
  EXPECT_EQ(error("q1,q2,x,y\n1,2,3,4\n"), "data.csv: missing column 'z'");
  EXPECT_EQ(error("q1,q2,q3,x,y,z\n1,2,3,4,5,6\n"), "data.csv: unknown column 'q3', did you mean 'q1'?");
  EXPECT_EQ(error("q1,q2,x,y,z,sigmma\n1,2,3,4,5,6\n"),
            "data.csv: unknown column 'sigmma', did you mean 'sigma'?");
  EXPECT_EQ(error("q1,q2,x,y,z,x\n1,2,3,4,5,6\n"), "data.csv: duplicate column 'x'");
  EXPECT_EQ(error("q1,q2,x,y,z,dir2\n1,2,3,4,5,1\n"), "data.csv: missing column 'dir1'");
}

TEST_F(MeasurementFile, NamesRowLineAndColumnOfWhatIsNoFiniteNumber) {
  const std::string good = "q1,q2,x,y,z\n1,2,3,4,5\n\n";
  EXPECT_EQ(error(good + "1,abc,3,4,5\n"), "data.csv: row 2 (line 4): q2: not a number: 'abc'");
  EXPECT_EQ(error(good + "1,2,nan,4,5\n"), "data.csv: row 2 (line 4): x: not a finite number: 'nan'");
  EXPECT_EQ(error(good + "1,2,3,-inf,5\n"), "data.csv: row 2 (line 4): y: not a finite number: '-inf'");
  EXPECT_EQ(error(good + "1,2,3,4,\n"), "data.csv: row 2 (line 4): z: missing, expected a number");
  EXPECT_EQ(error(good + "1,2,3,4,5 mm\n"), "data.csv: row 2 (line 4): z: not a number: '5 mm'");
  EXPECT_EQ(error(good + "1,2,3,4,0x5\n"), "data.csv: row 2 (line 4): z: not a number: '0x5'");
  EXPECT_EQ(error(good + "010,2,3,4,5\n"),
            "data.csv: row 2 (line 4): q1: a number with a leading zero: '010'");
}

TEST_F(MeasurementFile, NamesARowOfTooFewOrTooManyFields) {
  EXPECT_EQ(error("q1,q2,x,y,z\n1,2,3\n"), "data.csv: row 1 (line 2): y: missing, the row ends before it");
  EXPECT_EQ(error("q1,q2,x,y,z\n1,2,3,4,5,6\n"),
            "data.csv: row 1 (line 2): z: 6 fields in a row of 5 columns");
}

TEST_F(MeasurementFile, RefusesARowWithoutAReading) {
  EXPECT_EQ(error("q1,q2,x,y,z\n1,2,3,4,5\n1,2,0,0,0\n"),
            "data.csv: row 2 (line 3): x: x, y and z are all 0, which is no reading but a place left empty: "
            "remove the row or measure it again");
  EXPECT_EQ(load("q1,q2,x,y,z\n1,2,0,0,5\n").points.size(), 1U);
}

TEST_F(MeasurementFile, ChecksTheOptionalColumns) {
  const std::string rows = "1,2,3,4,5,";
  EXPECT_EQ(error("q1,q2,x,y,z,set\n" + rows + "test\n"),
            "data.csv: row 1 (line 2): set: expected identify or validate, found 'test'");
  EXPECT_EQ(error("q1,q2,x,y,z,payload_kg\n" + rows + "1\n"), "data.csv: missing column 'payload_x'");
  EXPECT_EQ(error("q1,q2,x,y,z,payload_kg,payload_x,payload_y,payload_z\n" + rows + "-1,0,0,0\n"),
            "data.csv: row 1 (line 2): payload_kg: expected 0 to 100000 kg, found -1");
  EXPECT_EQ(error("q1,q2,x,y,z,sigma\n" + rows + "0\n"),
            "data.csv: row 1 (line 2): sigma: expected more than 0 and at most 1000 mm, found 0");
  EXPECT_EQ(error("q1,q2,x,y,z,dir1,dir2\n" + rows + "1,2\n"),
            "data.csv: row 1 (line 2): dir2: expected -1, 0 or 1, found 2");
  EXPECT_EQ(error("q1,q2,x,y,z,dir1,dir2\n" + rows + "1,\n"),
            "data.csv: row 1 (line 2): dir2: missing, expected a number");
  EXPECT_EQ(error("q1,q2,x,y,z,temp1\n" + rows + "20\n"), "data.csv: missing column 'temp2'");
  EXPECT_EQ(error("q1,q2,x,y,z,temp1,temp2\n" + rows + "20,\n"),
            "data.csv: row 1 (line 2): temp2: missing, expected a number");
  EXPECT_EQ(error("q1,q2,x,y,z,temp1,temp2\n" + rows + "20,-273\n"),
            "data.csv: row 1 (line 2): temp2: expected a temperature of -50 to 200 C, found -273");
  EXPECT_EQ(
      error("q1,q2,x,y,z,a,b,c\n" + rows + "1,2,3\n"),
      "data.csv: a, b, c are the orientation of a 6-D target, and its standard deviation is missing. Add the "
      "column sigma_abc (deg), or remove a, b, c");
  EXPECT_EQ(error("q1,q2,x,y,z,a,b,c,sigma_abc\n" + rows + "1,400,3,0.01\n"),
            "data.csv: row 1 (line 2): b: expected -360 to 360 deg, found 400");
  EXPECT_EQ(error("q1,q2,x,y,z,a,b,c,sigma_abc\n" + rows + "1,,3,0.01\n"),
            "data.csv: row 1 (line 2): b: missing, expected a number");
  EXPECT_EQ(error("q1,q2,x,y,z,a,b,c,sigma_abc\n" + rows + "1,2,3,0\n"),
            "data.csv: row 1 (line 2): sigma_abc: expected more than 0 and at most 10 deg, found 0");
  EXPECT_EQ(error("q1,q2,x,y,z,pose\n" + rows + "1.5\n"),
            "data.csv: row 1 (line 2): pose: expected a whole number of 1 or more, found 1.5");
  EXPECT_EQ(error("q1,q2,x,y,z,smr\n" + rows + "\n"),
            "data.csv: row 1 (line 2): smr: missing, expected a reflector's name");
}

TEST_F(MeasurementFile, TakesDatesAndSecondsAsTimesAsTheyStand) {
  for (const auto& [first, second] : {std::pair{"2026-11-26T08:00:30.5Z", "2026-11-26T09:00:30+01:00"},
                                      {"2026-11-26 08:00:30", "2026-11-26 08:01:00"},
                                      {"0", "30.5"},
                                      {"1790000000", "1790000030"}}) {
    const MeasurementData data =
        load(std::string("q1,q2,x,y,z,time\n1,2,3,4,5,") + first + "\n2,2,3,4,5," + second + "\n");
    EXPECT_EQ(data.points[0].time, first);
    EXPECT_EQ(data.points[1].time, second);
  }
  EXPECT_EQ(load("q1,q2,x,y,z,time\n1,2,3,4,5,\n2,2,3,4,5,\n").points[0].time, "") << "all empty: no times";
  EXPECT_EQ(load("q1,q2,x,y,z,time\n1,2,3,4,5,7\n1,2,3,4,6,7\n").points[1].time, "7")
      << "two readings of one pose";
}

TEST_F(MeasurementFile, RefusesTimesThatItCannotTell) {
  const auto with_times = [this](const std::string& first, const std::string& second) {
    return error("q1,q2,x,y,z,time\n1,2,3,4,5," + first + "\n2,2,3,4,5," + second + "\n");
  };
  const std::string good = "2026-11-26T08:00:00Z";
  for (const char* text :
       {"x12", "08:00:30", "26.11.2026 08:00:00", "11/26/2026 08:00:00 AM", "1790000030000"}) {
    const std::string why =
        std::string(
            ": time: expected 2026-11-26T08:00:30 (T or a blank, with or without a fraction and a zone, Z or +01:00) "
            "or a number of seconds, found '") +
        text + "'";
    EXPECT_EQ(with_times(good, text), "data.csv: row 2 (line 3)" + why);
    EXPECT_EQ(with_times(text, good), "data.csv: row 1 (line 2)" + why);
  }
  const std::string missing =
      ": time: missing, where other rows have it: give every row its time or remove the column";
  EXPECT_EQ(with_times(good, ""), "data.csv: row 2 (line 3)" + missing);
  EXPECT_EQ(with_times("", good), "data.csv: row 1 (line 2)" + missing);
  EXPECT_EQ(
      with_times(good, "30"),
      "data.csv: row 2 (line 3): time: a number of seconds, where row 1 has a date with a zone: write all times in one form");
  EXPECT_EQ(
      with_times("2026-11-26 08:00:00", good),
      "data.csv: row 2 (line 3): time: a date with a zone, where row 1 has a date without a zone: write all times in one form");
  EXPECT_EQ(
      with_times("46000.000347", "46000.000694"),
      "data.csv: time: numbers are seconds, and 2 poses within 0.000347 s are not possible: write days of a spreadsheet as 2026-11-26T08:00:30");
}

TEST_F(MeasurementFile, SaysWhatIsWrongWithAFileAsAWhole) {
  EXPECT_EQ(error(""), "data.csv: the file is empty, expected a header row");
  EXPECT_EQ(error("q1,q2,x,y,z\n"), "data.csv: no rows of data");
  EXPECT_EQ(error("q1;q2;x;y;z\n1;2;3;4;5\n"), "data.csv: columns must be separated by commas");
  EXPECT_EQ(error("q1,q2,x,y,z,smr\n1,2,3,4,5,\"a\n"), "data.csv: line 2: a quote is not closed");
  EXPECT_EQ(error("q1,q2,x,y,z,smr\n1,2,3,4,5,\"a\"b\n"), "data.csv: line 2: text after a closing quote");
}

TEST_F(MeasurementFile, ComesBackBitByBit) {
  const std::string text =
      "q1,q2,x,y,z,smr,set,sigma,dir1,dir2,temp1,temp2,time,pose\n"
      "0.1,-10.042408075923612,2641.549557,1e-7,-7.852214157,\"a \"\"b\"\", "
      "c\",identify,0.01,-1,0,31.300000000000001,20,2026-01-02T03:04:05Z,7\n"
      "12.300000000000001,49.160806905516615,-0.30000000000000004,5,6,2,validate,,,,,,2026-01-02T03:04:35Z,3\n";
  const MeasurementData first = load(text);
  std::ostringstream out;
  write_measurements(out, first, robot_);
  const MeasurementData second = load(out.str());
  EXPECT_EQ(second.smr_names, first.smr_names);
  ASSERT_EQ(second.points.size(), first.points.size());
  for (std::size_t i = 0; i < first.points.size(); ++i) {
    EXPECT_EQ(second.points[i].q, first.points[i].q);
    EXPECT_EQ(second.points[i].p_WS_mm, first.points[i].p_WS_mm);
    EXPECT_EQ(second.points[i].smr, first.points[i].smr);
    EXPECT_EQ(second.points[i].set, first.points[i].set);
    EXPECT_EQ(second.points[i].sigma_mm, first.points[i].sigma_mm);
    EXPECT_EQ(second.points[i].direction, first.points[i].direction);
    EXPECT_EQ(second.points[i].temperature_c, first.points[i].temperature_c);
    EXPECT_EQ(second.points[i].time, first.points[i].time);
    EXPECT_EQ(second.points[i].pose, first.points[i].pose);
  }
}

TEST_F(MeasurementFile, EveryAngleOfAFileComesBackBitByBit) {
  RobotModel robot;
  robot.joints.resize(1);
  std::string text = "q1\n";
  for (int i = 0; i < 5000; ++i) text += format_number(-350 + i * 0.140625 + 1.0 / (i + 3)) + "\n";
  const auto first = load_joints(folder_.write("joints.csv", text), robot);
  std::ostringstream out;
  write_joints(out, first, robot);
  EXPECT_EQ(load_joints(folder_.write("again.csv", out.str()), robot), first);
}

}  // namespace
}  // namespace truepose::config
