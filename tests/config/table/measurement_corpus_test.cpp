// Measurement files as people have them: each is read with the numbers of the plain file, or refused with the
// sentence that helps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "config/measurement_file.hpp"
#include "config/table/table_reading.hpp"
#include "tests/config/error_of.hpp"
#include "tests/config/table/sheet.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

struct CorpusFile {
  std::string name, bytes;
  std::string refused{};  ///< part of the sentence; empty: it is read
  TableReading reading{};
};

Names six(const std::string& before, const std::string& after = "", int first = 1) {
  Names names;
  for (int k = first; k < first + 6; ++k) names.push_back(before + std::to_string(k) + after);
  return names;
}

const Names kXyz{"x", "y", "z"}, kXyzMm{"X [mm]", "Y [mm]", "Z [mm]"};

std::string krl_cell(const std::vector<std::string>& row, const std::string& more = ",E1 0.0") {
  std::string cell = "{E6AXIS: ";
  for (std::size_t k = 0; k < 6; ++k) cell += (k ? ",A" : "A") + std::to_string(k + 1) + " " + row[k];
  return cell + more + "}";
}

/// Joints as one KRL cell, and the rest of the row.
std::string krl_text(const Sheet& sheet, const std::string& separator, const std::string& quote,
                     const std::string& more) {
  std::string text = "joints" + separator + "x" + separator + "y" + separator + "z\n";
  for (const auto& row : sheet.rows)
    text += quote + krl_cell(row, more) + quote + separator +
            Sheet::line({row.begin() + 6, row.end()}, separator) + "\n";
  return text;
}

std::string row_number(std::size_t row) { return std::to_string(row); }

std::string padded(const Sheet& sheet, int width) {
  std::string text;
  for (const std::string& name : sheet.header) text += formatted("%*s", width, name.c_str());
  text += '\n';
  for (const auto& row : sheet.rows) {
    for (const std::string& field : row) text += formatted("%*s", width, field.c_str());
    text += '\n';
  }
  return text;
}

/// Rows between vertical bars, a rule below the header.
std::string bars(const Sheet& sheet, const std::string& frame) {
  std::string text;
  for (const std::string& row : {Sheet::line(sheet.header, " | "), std::string{"---|---"}})
    text += frame + " " + row + " " + frame + "\n";
  for (const auto& row : sheet.rows) text += frame + " " + Sheet::line(row, " | ") + " " + frame + "\n";
  return text;
}

std::string with_part(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A line for each column.
Sheet transposed(const Sheet& sheet) {
  Sheet lines;
  for (std::size_t k = 0; k < sheet.header.size(); ++k) {
    Names line{sheet.header[k]};
    for (const auto& row : sheet.rows) line.push_back(row[k]);
    if (k == 0)
      lines.header = std::move(line);
    else
      lines.rows.push_back(std::move(line));
  }
  return lines;
}

std::vector<CorpusFile> files_that_are_read() {
  const Sheet s = Sheet::correct();
  const Sheet german = s.with_decimal_commas();
  const Sheet kuka = s.with_header(plus(six("A"), {"X", "Y", "Z"}));
  const auto number = [](std::size_t row) { return std::to_string(row + 1); };
  const auto remark = [](std::size_t row) { return row % 3 == 0 ? std::string{"gut, ok"} : std::string{}; };
  const std::string zero = "0.0";
  const std::string degree = "\xC2\xB0", degree_1252 = "\xB0";
  const Names german_names = plus(six("A", " (" + degree + ")"), kXyzMm);
  const Names german_1252 = plus(six("A", " (" + degree_1252 + ")"), kXyzMm);
  const Names letters{"a", "b", "c", "d", "e", "f", "g", "h", "i"};
  const auto columns = [&](const Names& names) {
    TableReading reading;
    for (std::size_t k = 0; k < names.size(); ++k) reading.columns.push_back({s.header[k], names[k]});
    return reading;
  };
  const TableReading by_number = columns({"1", "2", "3", "4", "5", "6", "7", "8", "9"});
  const TableReading rad_m{.units = TableUnits{"rad", "m"}};
  const Sheet rad = s.scaled(0, 6, kDegree), rad_metres = rad.scaled(6, 9, 1e-3);
  std::vector<CorpusFile> files{
      {"plain", s.text()},
      {"plain with CRLF", s.text(",", "\r\n")},
      {"plain without a last line end", s.text().substr(0, s.text().size() - 1)},
      {"byte order mark", "\xEF\xBB\xBF" + s.text()},
      {"blanks behind commas", s.text(", ")},
      {"all quoted", s.each_field([](auto f) { return '"' + f + '"'; }).text()},
      {"semicolons, decimal commas", german.text(";")},
      {"semicolons, decimal points", s.text(";")},
      {"tabs", s.text("\t")},
      {"tabs, decimal commas", german.text("\t")},
      {"tabs, CRLF", kuka.text("\t", "\r\n")},
      {"vertical bars", s.text("|")},
      {"a table in Markdown", bars(s, "|")},
      {"a table of a database", bars(s, "")},
      {"columns of blanks", padded(s, 12)},
      {"columns of blanks, decimal commas", padded(german, 12)},
      {"single blanks", s.text(" ")},
      {"single blanks, decimal commas", german.text(" ")},
      {"commas, decimal commas in quotes", german.each_field([](auto f) { return '"' + f + '"'; }).text()},
      {"German Excel",
       "\xEF\xBB\xBF" + german.with_header(plus(six("A"), {"X", "Y", "Z"})).text(";", "\r\n")},
      {"German Excel with degree signs, UTF-8", german.with_header(german_names).text(";", "\r\n")},
      {"German Excel with degree signs, Windows-1252", german.with_header(german_1252).text(";", "\r\n")},
      {"German Excel with numbers and remarks", german.with_header(german_names)
                                                    .with_column(9, "Bemerkung", remark)
                                                    .with_column(0, "Nr", number)
                                                    .text(";", "\r\n")},
      {"German Grad", german.with_header(plus(six("Achse ", " [Grad]"), kXyzMm)).text(";")},
      {"German Excel saved as Unicode text",
       utf16(kuka.with_decimal_commas().text("\t", "\r\n"), true, true)},
      {"UTF-16 little-endian, mark", utf16(s.text(), true, true)},
      {"UTF-16 big-endian, mark", utf16(s.text(), false, true)},
      {"UTF-16 little-endian, no mark", utf16(s.text(), true, false)},
      {"UTF-16 big-endian, no mark", utf16(s.text(), false, false)},
      {"one title row", "Robot calibration cell 4\n" + s.text()},
      {"title row with commas", "Cell 4, tracker AT960, measured by M.\n" + s.text()},
      {"three title rows and a blank one", "Report\nCell;4\nDate;26.11.2026\n\n" + german.text(";")},
      {"title row filled up by Excel", "Messung Zelle 4;;;;;;;;\n" + german.text(";")},
      {"comment before the header", "# measured with tracker, mm and deg\n" + s.text()},
      {"comments by percent and slashes", "% made by matlab\n// 26.11.\n" + s.text()},
      {"comment with a quote", "# the arm \"Otto, 5' high\n" + s.text()},
      {"comments between the rows",
       with_part(s.text(), "\n" + s.rows[4][0], "\n# paused here\n" + s.rows[4][0])},
      {"a row made a comment",
       with_part(s.text(), "\n" + s.rows[4][0], "\n# " + Sheet::line(s.rows[3], ",") + "\n" + s.rows[4][0])},
      {"header as a comment, numpy", "# " + s.text(" ")},
      {"header as a comment with commas", "# " + s.text()},
      {"units below the header", with_part(s.text(), "z\n", "z\ndeg,deg,deg,deg,deg,deg,mm,mm,mm\n")},
      {"units in brackets below the header",
       with_part(kuka.text("\t"), "Z\n", "Z\n[deg]\t[deg]\t[deg]\t[deg]\t[deg]\t[deg]\t[mm]\t[mm]\t[mm]\n")},
      {"rad and m below the header",
       with_part(rad_metres.text(), "z\n", "z\nrad,rad,rad,rad,rad,rad,m,m,m\n")},
      {"trailing commas", s.text(",", ",\n")},
      {"trailing semicolons behind the rows alone", with_part(german.text(";", ";\n"), "z;\n", "z\n")},
      {"empty last rows", s.text() + std::string(",,,,,,,,\n") + ",,,,,,,,\n"},
      {"empty last rows of semicolons", german.text(";") + ";;;;;;;;\n;;;;;;;;\n"},
      {"index of pandas", s.with_column(0, "", row_number).text()},
      {"index of pandas read again", s.with_column(0, "Unnamed: 0", number).text()},
      {"row names of R", with_part(s.with_column(0, "_", number).text(), "_,", "")},
      {"A1..A6", kuka.text()},
      {"lower case a1", s.with_header(plus(six("a"), kXyz)).text()},
      {"J1..J6", s.with_header(plus(six("J"), kXyz)).text()},
      {"Q1..Q6, XYZ", s.with_header(plus(six("Q"), {"X", "Y", "Z"})).text()},
      {"joint_1..", s.with_header(plus(six("joint_"), kXyz)).text()},
      {"Joint 1..", s.with_header(plus(six("Joint "), kXyz)).text()},
      {"JOINT1..", s.with_header(plus(six("JOINT"), kXyz)).text()},
      {"joint_0..joint_5", s.with_header(plus(six("joint_", "", 0), kXyz)).text()},
      {"q[0]..q[5]", s.with_header(plus(six("q[", "]", 0), kXyz)).text()},
      {"axis 1..", s.with_header(plus(six("Axis "), kXyz)).text()},
      {"theta1..", s.with_header(plus(six("theta"), kXyz)).text()},
      {"AIPos.A1", s.with_header(plus(six("AIPos.A"), kXyz)).text()},
      {"$AXIS_ACT.A1", s.with_header(plus(six("$AXIS_ACT.A"), kXyz)).text()},
      {"units in names", s.with_header(plus(six("A", " (deg)"), kXyzMm)).text()},
      {"units behind underscores", s.with_header(plus(six("q", "_deg"), {"x_mm", "y_mm", "z_mm"})).text()},
      {"units behind slashes", s.with_header(plus(six("q", "/deg"), {"X/mm", "Y/mm", "Z/mm"})).text()},
      {"rad in names", rad.with_header(plus(six("q", "_rad"), kXyz)).text()},
      {"rad and m in names", rad_metres.with_header(plus(six("J", " [rad]"), {"x_m", "y_m", "z_m"})).text()},
      {"m in names", s.scaled(6, 9, 1e-3).with_header(plus(six("q"), {"x [m]", "y [m]", "z [m]"})).text()},
      {"cm in names", s.scaled(6, 9, 0.1).with_header(plus(six("q"), {"x [cm]", "y [cm]", "z [cm]"})).text()},
      {"inches in names",
       s.scaled(6, 9, 1 / 25.4).with_header(plus(six("q"), {"X (in)", "Y (in)", "Z (in)"})).text()},
      {"units in the cells", s.each_field([](auto f) { return f; }).with_header(plus(six("q"), kXyz)).text()},
      {"units by --units", rad_metres.text(), "", rad_m},
      {"units by --units under other names",
       rad_metres.with_header(plus(six("A"), {"X", "Y", "Z"})).text(";"), "", rad_m},
      {"tracker_x", s.with_header(plus(six("q"), {"tracker_x", "tracker_y", "tracker_z"})).text()},
      {"X measured", s.with_header(plus(six("q"), {"X measured", "Y measured", "Z measured"})).text()},
      {"further columns", s.with_column(9, "RMS", zero)
                              .with_column(0, "Name", number)
                              .with_column(0, "Operator", remark)
                              .text(";")},
      {"external axes at zero", kuka.with_column(6, "E2", zero).with_column(6, "E1", zero).text()},
      {"an external axis that stands at 500",
       kuka.with_column(6, "E1", [](std::size_t row) { return row % 2 ? "500" : "500.0"; }).text()},
      {"KRL cells, semicolons", krl_text(s, ";", "\"", ",E1 0.0")},
      {"KRL cells without quotes", krl_text(s, ";", "", ",E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0")},
      {"KRL cells between commas", krl_text(s, ",", "", "")},
      {"KRL cells behind tabs", krl_text(s, "\t", "", "")},
      {"columns by --columns", s.with_header(letters).text(), "", columns(letters)},
      {"no header, columns by number", s.rows_text(), "", by_number},
      {"no header, tabs, decimal commas, columns by number", german.rows_text("\t"), "", by_number},
      {"a second x that --columns settles",
       s.with_column(9, "X [mm]", zero).text(),
       "",
       {.columns = {{"x", "x"}}}},
      {"minus signs of a typesetter",
       s.each_field([](auto f) { return with_part(f, "-", "\xE2\x88\x92"); }).text()},
      {"no-break blanks", kuka.text(";\xC2\xA0")},
      {"plus signs", s.each_field([](auto f) { return f[0] == '-' ? f : "+" + f; }).text(";")},
      {"exponents", s.each_field([](auto f) { return formatted("%.9E", std::stod(f)); }).text(";")},
      {"exponents, decimal commas",
       s.each_field([](auto f) { return with_part(formatted("%.9E", std::stod(f)), ".", ","); }).text(";")}};
  Sheet with_units = s;
  for (auto& row : with_units.rows)
    for (std::size_t k = 0; k < row.size(); ++k) row[k] += k < 6 ? " deg" : "mm";
  files.push_back({"units behind the numbers", with_units.text(";")});
  return files;
}

std::vector<CorpusFile> files_that_are_refused() {
  const Sheet s = Sheet::correct();
  const Sheet german = s.with_decimal_commas();
  const auto grouped = [](const std::string& field) {
    const auto point = field.find('.');
    if (point < 4 || field[0] == '-') return with_part(field, ".", ",");
    return field.substr(0, point - 3) + "." + field.substr(point - 3, 3) + "," + field.substr(point + 1);
  };
  return {
      {"empty", "", "the file is empty, expected a header row"},
      {"blank lines alone", "\n \n\n", "the file is empty, expected a header row"},
      {"header alone", Sheet{s.header, {}}.text(), "no rows of data"},
      {"header alone, semicolons", Sheet{s.header, {}}.text(";"), "no rows of data"},
      {"no header", s.rows_text(),
       "has no header: its first row (line 1) is of numbers. Say what its 9 columns are: --columns q1=1,q2=2,q3=3,.., or write a header row"},
      {"no header, German", german.rows_text(";"), "has no header"},
      {"workbook", std::string("PK\x03\x04\x14\0\x06\0", 8),
       "is an Excel workbook (.xlsx) or another zip file, not text: in Excel or LibreOffice save the sheet as CSV"},
      {"old workbook", "\xD0\xCF\x11\xE0\xA1\xB1", "is an old Excel workbook (.xls), not text"},
      {"thousands with points, decimal commas", s.each_field(grouped).text(";"),
       "has its thousands set apart: export numbers without that"},
      {"thousands with blanks", s.with_field(2, 6, "1 234.5").text(";"),
       "row 3 (line 4): x: '1 234.5' has its thousands set apart"},
      {"thousands with apostrophes", s.with_field(2, 6, "1'234.5").text(";"), "has its thousands set apart"},
      {"a point among decimal commas", german.with_field(2, 6, "1.234").text(";"),
       "row 3 (line 4): x: '1.234' has a point where other numbers have a decimal comma"},
      {"decimal commas between commas", german.text(),
       "18 fields in a row of 9 columns. Where decimal commas and separators are alike"},
      {"commas that may set thousands apart",
       "q1;q2;q3;q4;q5;q6;x;y;z\n1;2;3;4;5;6;1,234;2,345;3,456\n2;3;4;5;6;7;1,244;2,445;3,556\n",
       "row 1 (line 2): x: '1,234' may be 1.234 or 1234"},
      {"missing x", s.with_header(plus(six("A"), {"u", "Y", "Z"})).text(),
       "missing column 'x', found 'u'. Say which it is: --columns x=NAME"},
      {"missing joints", s.with_header(plus({"base", "shoulder", "elbow", "w1", "w2", "w3"}, kXyzMm)).text(),
       "missing column 'q1', found 'base', 'shoulder'"},
      {"joints of a robot in ROS",
       s.with_header(
            plus({"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "w1", "w2", "w3"}, kXyz))
           .text(),
       "missing column 'q1', found 'shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint', 'w1', 'w2', 'w3'. "
       "Say which it is: --columns q1=NAME,q2=NAME,q3=NAME,.."},
      {"joint states of ROS, which have an order of their own",
       s.with_header(plus(six("joint_states.position[", "]", 0), kXyz)).text(),
       "missing column 'q1', found 'joint_states.position[0]'"},
      {"the robot's own orientation",
       s.with_column(9, "C", "0.0").with_column(9, "B", "0.0").with_column(9, "A", "0.0").text(),
       "a, b, c are the orientation of a 6-D target, and its standard deviation is missing. Add the column "
       "sigma_abc (deg), or remove a, b, c"},
      {"a row for each quantity", transposed(s).text(),
       "has a row for each of 'q1', 'q2', 'q3', 'q4', 'q5', 'q6', 'x', 'y', 'z'. Transpose the table: a row for "
       "each pose, a column for each of these"},
      {"a row for each quantity, German", "Zelle 4\n" + transposed(german).text(";"), "Transpose the table"},
      {"no name known", s.with_header({"aa", "bb", "cc", "dd", "ee", "ff", "gg", "hh", "ii"}).text(";"),
       "no column is known, found 'aa', 'bb'"},
      {"x twice", s.with_column(9, "X", "1").text(),
       "columns 'x' and 'X' may both be x. Say which: --columns x=\"x\""},
      {"joints of two kinds", s.with_column(9, "J1", "1").with_column(9, "A1", "1").text(), "may both be q1"},
      {"tracker and robot x",
       s.with_header(plus(six("A"), {"tracker_x", "tracker_y", "tracker_z"})).with_column(9, "x", "1").text(),
       "columns 'tracker_x' and 'x' may both be x"},
      {"an external axis that moves",
       s.with_header(plus(six("A"), kXyzMm)).with_column(6, "E1", row_number).text(),
       "row 2 (line 3): E1: moves ('0' in row 1, here '1'), and the arm has no such axis"},
      {"a seventh joint that moves",
       s.with_header(plus(six("A"), kXyzMm)).with_column(6, "A7", row_number).text(), "A7: moves"},
      {"a word for a number, German", german.with_field(3, 2, "defekt").text(";"),
       "row 4 (line 5): q3: not a number: 'defekt'"},
      {"an empty cell, German", german.with_field(3, 2, "").text(";"),
       "row 4 (line 5): q3: missing, expected a number"},
      {"#N/A of Excel", german.with_field(3, 2, "#NV").text(";"), "row 4 (line 5): q3: not a number: '#NV'"},
      {"#N/A in the first column", s.with_field(3, 0, "#N/A").text(),
       "row 4 (line 5): q1: not a number: '#N/A'"},
      {"a short row, German", german.text(";") + "1;2;3\n",
       "row 13 (line 14): q4: missing, the row ends before it"},
      {"a long row, German", german.text(";") + "1;2;3;4;5;6;7;8;9;10\n",
       "row 13 (line 14): z: 10 fields in a row of 9 columns"},
      {"header twice", s.text(";") + s.text(";"), "row 13 (line 14): q1: not a number: 'q1'"},
      {"all zero, German", german.text(";") + "1;2;3;4;5;6;0;0;0\n",
       "x, y and z are all 0, which is no reading"},
      {"units that contradict --units",
       s.with_header(plus(six("A", " (deg)"), kXyzMm)).text(),
       "column 'A1 (deg)' says deg, and --units says rad",
       {.units = TableUnits{"rad", "mm"}}},
      {"one joint in rad", s.with_header(plus({"A1 (rad)", "A2", "A3", "A4", "A5", "A6"}, kXyz)).text(),
       "column 'A1 (rad)' is in rad, and 'A2' says no unit: name the unit of all"},
      {"joints in mm", s.with_header(plus(six("A", " (mm)"), kXyzMm)).text(),
       "column 'A1 (mm)' is in mm, and q1 is an angle"},
      {"points in deg", s.with_header(plus(six("A"), {"x_deg", "y_deg", "z_deg"})).text(),
       "column 'x_deg' is in deg, and x is a length"},
      {"units of the numbers change",
       [&] {
         Sheet sheet = s;
         for (auto& row : sheet.rows) row[6] += " mm";
         sheet.rows[5][6] = "1.5 m";
         return sheet.text(";");
       }(),
       "row 6 (line 7): x: is in m, where others are in mm: write all in one unit"},
      {"KRL cells of different members", with_part(krl_text(s, ";", "", ""), ",A6 ", ",B6 "),
       "expected an aggregate of the same members as in row 1"},
      {"a comment that may be a name",
       "Name;A1;A2;A3;A4;A5;A6;X;Y;Z\n" +
           s.with_column(0, "n", [](std::size_t row) { return row == 2 ? "#3" : "p"; }).rows_text(";"),
       "line 4: '#3' may be a comment or a name"},
      {"UTF-16 that is cut off", utf16(s.text(), true, true) + "1",
       "is cut off: UTF-16 with an odd number of bytes"},
      {"SpatialAnalyzer points alone",
       "Collection::Group::Point, X, Y, Z, Time Stamp\nA::CAL::p1, 2626.38131, 1423.72334, 1621.54991, 11/27/2026 8:00:00 AM\n",
       "missing column 'q1', found 'Collection::Group::Point', 'Time Stamp'"},
      {"a quote that stays open", with_part(german.text(";"), german.rows[3][0], "\"" + german.rows[3][0]),
       "a quote is not closed"},
  };
}

class MeasurementCorpus : public testing::Test {
 protected:
  std::string error(const CorpusFile& file) {
    const auto path = folder_.write("data.csv", file.bytes);
    return error_of([&] { load(file); }, path);
  }
  MeasurementData load(const CorpusFile& file) {
    TableReading reading = file.reading;
    reading.report = [this](const std::string& line) { said_ = line; };
    said_.clear();
    return load_measurements(folder_.write("data.csv", file.bytes), robot_, &reading);
  }
  void expect_plain_numbers(const CorpusFile& file) {
    const MeasurementData plain =
        load_measurements(folder_.write("plain.csv", Sheet::correct().text()), robot_);
    MeasurementData data;
    ASSERT_NO_THROW(data = load(file)) << error(file);
    ASSERT_EQ(data.points.size(), plain.points.size());
    for (std::size_t k = 0; k < plain.points.size(); ++k) {
      EXPECT_LT((data.points[k].q - plain.points[k].q).norm(), 1e-9) << "row " << k + 1;
      EXPECT_LT((data.points[k].p_WS_mm - plain.points[k].p_WS_mm).norm(), 1e-6) << "row " << k + 1;
      EXPECT_EQ(data.points[k].row, plain.points[k].row);
    }
  }

  TempFolder folder_;
  RobotModel robot_ = example::kr210();
  std::string said_;
};

TEST_F(MeasurementCorpus, HasEightyFiles) {
  EXPECT_GE(files_that_are_read().size() + files_that_are_refused().size(), 80U);
}

TEST_F(MeasurementCorpus, FilesOfOtherProgramsHaveTheNumbersOfThePlainOne) {
  for (const CorpusFile& file : files_that_are_read()) {
    SCOPED_TRACE(file.name);
    expect_plain_numbers(file);
  }
}

TEST_F(MeasurementCorpus, WhatIsNotReadIsRefusedWithTheSentenceThatHelps) {
  for (const CorpusFile& file : files_that_are_refused()) {
    SCOPED_TRACE(file.name);
    EXPECT_THAT(error(file), HasSubstr("data.csv: "));
    EXPECT_THAT(error(file), HasSubstr(file.refused));
  }
  const TableReading reading;
  const auto robot = folder_.write("arm.yaml", "name: r\njoints:\n  - {a: 0, alpha: 0}\n");
  EXPECT_EQ(error_of([&] { load_measurements(robot, robot_, &reading); }, robot),
            "arm.yaml: is no table. Give a CSV file");
}

TEST_F(MeasurementCorpus, AFileInTheOwnFormIsReadWithoutAWord) {
  load({"plain", Sheet::correct().text()});
  EXPECT_EQ(said_, "");
  load({"plain with names", Sheet::correct()
                                .with_column(0, "smr", "left, top")
                                .each_field([](auto f) { return f.contains(' ') ? "\"" + f + "\"" : f; })
                                .text()});
  EXPECT_EQ(said_, "");
}

TEST_F(MeasurementCorpus, OneLineSaysWhatWasReadHow) {
  const Sheet sheet = Sheet::correct().with_decimal_commas().with_header(plus(six("A", " (deg)"), kXyzMm));
  load({"German", "Zelle 4\n" + sheet.with_column(0, "Nr", row_number).text(";")});
  EXPECT_THAT(
      said_,
      HasSubstr(
          "data.csv: read as: semicolons; header in line 2; decimal commas; q1..q6 from 'A1 (deg)'..'A6 (deg)', x from "
          "'X [mm]', y from 'Y [mm]', z from 'Z [mm]'; left out: 'Nr'"));
}

TEST_F(MeasurementCorpus, PointsBesideJointsOfOtherNamesAskForTheirColumns) {
  const auto path = folder_.write(
      "data.csv", Sheet::correct().with_header(plus(six("ur10_joint_", "_deg", 1), kXyz)).text());
  TableReading reading{.report = [this](const std::string& line) { said_ = line; }};
  read_table(path, {.known = {"q1", "x", "y", "z"}, .needed = {{"x", "y", "z"}, {"q1"}}}, &reading);
  EXPECT_THAT(said_, HasSubstr("left out: 'ur10_joint_1_deg'"));
  EXPECT_THAT(said_, HasSubstr("no joints: if some of these are, say which: --columns q1=NAME,q2=NAME"));
}

/// A correct file written in a way that is drawn: each way alone is in the corpus.
CorpusFile drawn_file(std::minstd_rand& random) {
  const auto one_of = [&](const std::vector<std::string>& choices) {
    return choices[random() % choices.size()];
  };
  const auto so = [&] { return random() % 2 == 0; };
  const std::string separator = one_of({",", ";", "\t"});
  const bool commas = separator != "," && so();
  const std::string angle = one_of({"", "deg", "rad"}), length = one_of({"", "mm", "m", "cm", "inch"});
  const bool has_units_row = so();
  const auto name = [&](const std::string& plain, const std::string& unit) {
    return unit.empty() || has_units_row ? plain : plain + (so() ? " [" + unit + "]" : " (" + unit + ")");
  };
  const double per_mm = length == "m" ? 1e-3 : length == "cm" ? 0.1 : length == "inch" ? 1 / 25.4 : 1;
  Sheet sheet = Sheet::correct().scaled(0, 6, angle == "rad" ? kDegree : 1).scaled(6, 9, per_mm);
  const std::string family = one_of({"q", "A", "J", "Joint ", "joint_", "AXIS"});
  const bool upper = so();
  for (std::size_t k = 0; k < 6; ++k) sheet.header[k] = name(family + std::to_string(k + 1), angle);
  for (std::size_t k = 6; k < 9; ++k)
    sheet.header[k] = name(std::string(1, (upper ? "XYZ" : "xyz")[k - 6]), length);
  Names units = plus(Names(6, angle), Names(3, length));
  const auto add = [&](std::size_t place, const std::string& title, const std::string& field) {
    sheet = sheet.with_column(place, title, field);
    units.insert(units.begin() + static_cast<std::ptrdiff_t>(place), "");
  };
  if (so()) add(6, "E1", "0.0");
  if (so()) add(sheet.header.size(), "Bemerkung", one_of({"gut", "", "n. i. O."}));
  if (so()) add(0, one_of({"Nr", "Messung", "Operator"}), "1");
  if (commas) sheet = sheet.with_decimal_commas();
  const std::string end = (so() ? separator : "") + std::string(so() ? "\r\n" : "\n");
  std::string text;
  if (so()) text += one_of({"Cell 4", "# made by a script", "% 26.11.2026", "// deg and mm"}) + "\n";
  text += Sheet::line(sheet.header, separator) + end;
  if (has_units_row && !(angle.empty() && length.empty())) text += Sheet::line(units, separator) + end;
  text += sheet.rows_text(separator, end);
  if (so()) text += std::string(sheet.header.size() - 1, separator[0]) + "\n";
  switch (random() % 4) {
    case 0:
      return {text, utf16(text, so(), true)};
    case 1:
      return {text, "\xEF\xBB\xBF" + text};
    case 2:
      return {text, utf16(text, so(), false)};
    default:
      return {text, text};
  }
}

TEST_F(MeasurementCorpus, AnyCombinationOfThemIsReadWithTheSameNumbers) {
  std::minstd_rand random{48};
  for (int trial = 0; trial < 300; ++trial) {
    const CorpusFile file = drawn_file(random);
    SCOPED_TRACE(file.name);
    expect_plain_numbers(file);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace truepose::config
