// What other programs add to a measurement file, one case each: read with the numbers of the plain file, or
// refused with the sentence that helps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "config/measurement_file.hpp"
#include "config/table/table_reading.hpp"
#include "tests/config/error_of.hpp"
#include "tests/config/table/sheet.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;

class MeasurementVariants : public testing::Test {
 protected:
  static Names joints(const std::string& before, const std::string& after = "") {
    Names names;
    for (int k = 1; k <= 6; ++k) names.push_back(before + std::to_string(k) + after);
    return names;
  }
  static Names joints_and(const std::string& before, const Names& more) { return plus(joints(before), more); }
  /// Joints A1..A6 and X, Y, Z, and three columns of other numbers.
  static Sheet with_more(const Names& more) {
    Sheet sheet = Sheet::correct().with_header(joints_and("A", {"X", "Y", "Z"}));
    for (const std::string& name : more) sheet = sheet.with_column(sheet.header.size(), name, "1.5");
    return sheet;
  }
  MeasurementData load(const std::string& text, TableReading reading = {}) {
    reading.report = [this](const std::string& line) { said_ = line; };
    return load_measurements(folder_.write("data.csv", text), robot_, &reading);
  }
  void expect_read(const std::string& text, const TableReading& reading = {}) {
    SCOPED_TRACE(text.substr(0, text.find('\n', text.find('\n') + 1)));
    const auto plain = load_measurements(folder_.write("plain.csv", Sheet::correct().text()), robot_);
    MeasurementData data;
    ASSERT_NO_THROW(data = load(text, reading)) << refusal(text, reading);
    ASSERT_EQ(data.points.size(), plain.points.size());
    for (std::size_t k = 0; k < plain.points.size(); ++k) {
      EXPECT_LT((data.points[k].q - plain.points[k].q).norm(), 1e-9) << "row " << k + 1;
      EXPECT_LT((data.points[k].p_WS_mm - plain.points[k].p_WS_mm).norm(), 1e-6) << "row " << k + 1;
    }
  }
  std::string refusal(const std::string& text, const TableReading& reading = {}) {
    return error_of([&] { load(text, reading); }, folder_.write("data.csv", text));
  }

  static constexpr double kGonPerDegree = 10.0 / 9;
  TempFolder folder_;
  RobotModel robot_ = example::kr210();
  std::string said_;
};

TEST_F(MeasurementVariants, TheRobotsOwnPositionDoesNotPassForTheTrackersReading) {
  EXPECT_THAT(refusal(with_more({"LT_X", "LT_Y", "LT_Z"}).text()),
              HasSubstr("columns 'X' and 'LT_X' may both be x. Say which: --columns x=\"X\" or x=\"LT_X\""));
  EXPECT_THAT(refusal(with_more({"X_ist", "Y_ist", "Z_ist"}).text(";")),
              HasSubstr("columns 'X' and 'X_ist' may both be x"));
  EXPECT_THAT(refusal(with_more({"X.1", "Y.1", "Z.1"}).text()),
              HasSubstr("columns 'X' and 'X.1' may both be x"));
  EXPECT_THAT(refusal(with_more({"X", "Y", "Z"}).text()), HasSubstr("--columns x=7 or x=10"));
  expect_read(with_more({"LT_X", "LT_Y", "LT_Z"}).text(), {.columns = {{"x", "X"}, {"y", "Y"}, {"z", "Z"}}});
  for (const std::string other : {" nominal", " std", "_soll", "_cmd"})
    expect_read(with_more({"X" + other, "Y" + other, "Z" + other}).text());
  expect_read(Sheet::correct()
                  .with_header(joints_and("A", {"X_tracker", "Y_tracker", "Z_tracker"}))
                  .with_column(9, "X_ist", "1.5")
                  .text());
}

TEST_F(MeasurementVariants, CommandedJointsDoNotPassForThoseReached) {
  Sheet both = with_more({});
  for (int k = 6; k >= 1; --k) both = both.with_column(0, "A" + std::to_string(k) + "_soll", "10");
  for (std::size_t k = 6; k < 12; ++k) both.header[k] += "_Ist [\xC2\xB0]";
  expect_read(both.text(";"));
  EXPECT_THAT(refusal(with_more({"A1_act"}).text()), HasSubstr("columns 'A1' and 'A1_act' may both be q1"));
  EXPECT_THAT(refusal(with_more({"q0", "q1"}).text()), HasSubstr("columns 'A1' and 'q1' may both be q1"));
  expect_read(with_more({"A1 torque", "A1_current", "ASPos.A1"}).text());
}

TEST_F(MeasurementVariants, ARowOfSumsIsNoMeasurement) {
  const Sheet numbered =
      with_more({}).with_column(0, "Nr", [](std::size_t row) { return std::to_string(row + 1); });
  const std::string numbers = ";1;2;3;4;5;6;700;800;900\n";
  for (const std::string name : {"Mittelwert", "Mean", ""})
    EXPECT_THAT(refusal(numbered.text(";") + name + numbers),
                HasSubstr("row 13 (line 14): Nr: '" + name +
                          "' is not named as the other rows are. Remove the row if it is a sum or a mean"));
  EXPECT_THAT(refusal(numbered.text(";") + "Min" + numbers + "Max" + numbers), HasSubstr("row 13 (line 14)"));
  const auto named_by = [](const std::string& header) {
    return with_more({}).with_column(0, header, [](std::size_t row) { return "P" + std::to_string(row); });
  };
  for (const std::string header : {"Name", "point", "Pose"})
    EXPECT_THAT(refusal(named_by(header).text(";") + "Mean" + numbers),
                HasSubstr("row 13 (line 14): " + header + ": 'Mean'"));
  expect_read(with_more({})
                  .with_column(0, "Operator", [](std::size_t row) { return row % 2 ? "Max" : "Otto"; })
                  .text());
}

TEST_F(MeasurementVariants, RowsThatAreNotValidByTheirOwnColumnAreLeftOut) {
  for (const auto& [yes, no] : {std::pair{"1", "0"}, {"True", "False"}, {"ja", "nein"}}) {
    std::string text = with_more({}).with_column(0, "Valid", yes).text(";");
    expect_read(text + no + std::string{";1;2;3;4;5;6;700;800;900\n"});
    EXPECT_THAT(said_, HasSubstr("1 row left out, not valid by 'Valid'"));
  }
  EXPECT_THAT(refusal(with_more({}).with_column(0, "is_valid", "0").text()),
              HasSubstr("'is_valid' says of each row that it is not valid"));
}

TEST_F(MeasurementVariants, ThousandsThatMayBeDecimalsAreBothNamed) {
  Sheet sheet = with_more({});
  for (auto& row : sheet.rows)
    row[row.size() - 3] = "1.500", row[row.size() - 2] = "200", row.back() = "1.800";
  EXPECT_THAT(refusal(sheet.text(";")),
              HasSubstr("X: '1.500' may be 1.500 or 1500, as other coordinates have no point"));
  sheet.rows[3].back() = "1.8";
  EXPECT_NO_THROW(load(sheet.text(";")));
}

TEST_F(MeasurementVariants, NamesInAnotherEncodingAreNotTakenForOurs) {
  const std::string gbk = "\xB9\xD8,\xBD\xDA,\xD7\xF8\n1,2,3\n4,5,6\n";
  EXPECT_THAT(refusal(gbk),
              HasSubstr("The file was read as Windows-1252: if its names are others, save it as UTF-8"));
}

TEST_F(MeasurementVariants, NamesOfFurtherProgramsAndLanguagesAreRead) {
  const Sheet sheet = Sheet::correct();
  for (const std::string name :
       {"Axe ", "rax_", "joint_a", "J0", "eje", "Gelenk ", "\xE5\x85\xB3\xE8\x8A\x82"})
    expect_read(sheet.with_header(joints_and(name, {"x", "y", "z"})).text(";"));
  const std::string measured = " mesur\xC3\xA9";
  expect_read(sheet.with_decimal_commas()
                  .with_header(joints_and("Axe", {"X" + measured, "Y" + measured, "Z" + measured}))
                  .with_column(0, "X nominal", "1,5")
                  .text(";"));
  expect_read(
      with_more({}).with_column(0, "Pose", [](std::size_t row) { return "P" + std::to_string(row); }).text());
  EXPECT_THAT(said_, HasSubstr("left out: 'Pose'"));
}

TEST_F(MeasurementVariants, GonAndMicrometresAreRead) {
  const Sheet gon = Sheet::correct().scaled(0, 6, kGonPerDegree).scaled(6, 9, 1000);
  expect_read(
      gon.with_header(plus(joints("A", " [gon]"), {"X [\xC2\xB5m]", "Y [um]", "Z (micron)"})).text(";"));
  const std::string units = "Unit;gon;gon;gon;gon;gon;gon;um;um;um\n";
  const Sheet named = gon.with_column(0, "Name", "p");
  expect_read(Sheet::line(named.header, ";") + "\n" + units + named.rows_text(";"));
}

TEST_F(MeasurementVariants, AUnitThatIsNotReadIsNamed) {
  const auto header = [](const std::string& unit) {
    return plus(joints("A", " [" + unit + "]"), {"X", "Y", "Z"});
  };
  EXPECT_THAT(refusal(Sheet::correct().with_header(header("mrad")).text()),
              HasSubstr("column 'A1 [mrad]' is in mrad, which is not read. Convert it to deg"));
  EXPECT_THAT(refusal(Sheet::correct().with_header(header("rad")).text()),
              HasSubstr("beyond any arm (3600)"));
  EXPECT_THAT(refusal(Sheet::correct().with_header(joints_and("A", {"x_m", "y_m", "z_m"})).text()),
              HasSubstr("mm, beyond any arm (100000). Correct the unit of this column"));
  EXPECT_THAT(refusal(Sheet::correct().each_field([](auto f) { return "=\"" + f + "\""; }).text(";")),
              HasSubstr("row 1 (line 2): q1: not a number: '=\""));
}

TEST_F(MeasurementVariants, AFileThatIsNoTableIsCalledWhatItIs) {
  EXPECT_THAT(refusal("{\"q1\": 1.5, \"x\": 3}\n{\"q1\": 2.5, \"x\": 4}\n"),
              HasSubstr("data.csv: is JSON, not a table"));
  EXPECT_THAT(refusal("[\n {\n  \"q1\": 1.5\n }\n]\n"), HasSubstr("is JSON"));
  EXPECT_THAT(refusal("<?xml version=\"1.0\"?><Workbook/>"), HasSubstr("is XML or HTML"));
  EXPECT_THAT(refusal(std::string("\x93NUMPY\x01\0v\0{'descr': '<f8'}", 27)), HasSubstr("is binary"));
}

TEST_F(MeasurementVariants, WithoutColumnsTheReasonIsNamed) {
  EXPECT_THAT(refusal("# Created by Octave\n# rows: 12\n" + Sheet::correct().rows_text(" ")),
              HasSubstr("has no header: its first row (line 3) is of numbers"));
  EXPECT_THAT(refusal(Sheet::correct().text(":")),
              HasSubstr("line 1 is one column, 'q1:q2:q3:q4:q5:q6:x:y:z'. Separate columns by commas"));
  EXPECT_THAT(refusal(Sheet::correct().each_field([](auto f) { return f + "D+00"; }).text(" ")),
              HasSubstr("row 1 (line 2): q1: not a number: '"));
  EXPECT_THAT(refusal(with_more({}).text(), {.columns = {{"x", "12"}}}),
              HasSubstr("has no column '12', which --columns gives for x. It has 9: 'A1', 'A2'"));
  EXPECT_THAT(refusal("q1;q2;q3;q4;q5;q6;P\n1;2;3;4;5;6;(700.5, 800.5, 900.5)\n"),
              HasSubstr("row 1 (line 2): P: '(700.5, 800.5, 900.5)' is several numbers in one cell"));
}

TEST_F(MeasurementVariants, MarksOfTypesettersAreRead) {
  expect_read(Sheet::correct()
                  .each_field([](auto f) { return f[0] == '-' ? "\xE2\x80\x93" + f.substr(1) : f; })
                  .text(";"));
  EXPECT_THAT(refusal(Sheet::correct()
                          .with_field(2, 6,
                                      "1\xE2\x80\x99"
                                      "234.5")
                          .text(";")),
              HasSubstr("row 3 (line 4): x: '1'234.5' has its thousands set apart"));
}

}  // namespace
}  // namespace truepose::config
