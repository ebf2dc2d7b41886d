#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "config/table/csv_reader.hpp"

namespace truepose::config {
namespace {

/// The column x, read row by row.
std::vector<double> streamed(const std::string& text) {
  std::istringstream in(text);
  CsvStream rows(in, "f.csv");
  std::vector<double> x;
  while (rows.next()) x.push_back(rows.number(rows.header().column("x")));
  return x;
}

TEST(CsvStream, TakesAQuoteThatOpensNoFieldForAnOrdinaryCharacter) {
  for (const std::string header : {"a\",b,x\n", "a, \"b,x\n", "\"a\",b\"b,x\n"}) {
    const std::string text = header + "1,2,3\n\"4\"\"\n\",5,6\n";
    EXPECT_EQ(CsvTable::parse(text, "f.csv").row_count(), 2u) << text;
    EXPECT_EQ(streamed(text), (std::vector<double>{3, 6})) << text;
  }
}

TEST(CsvField, IsNoFormulaToASpreadsheetAndIsReadAsItWas) {
  for (const std::string text :
       {"=cmd|' /C calc'!A0", "+1", "-1", "@sum", "\t=1", "'=1", "''=1", "plain", "'quoted'", ""}) {
    const std::string field = csv_field(text);
    const std::string shown = field.starts_with('"') ? field.substr(1) : field;
    EXPECT_TRUE(shown.empty() || !std::string_view{"=+-@\t"}.contains(shown[0])) << field;
    const CsvTable read = CsvTable::parse("a,b\n" + field + ",1\n", "f.csv");
    EXPECT_EQ(read.text(0, read.column("a")), text) << field;
  }
}

TEST(CsvStream, TakesALineBreakInQuotesForPartOfItsField) {
  EXPECT_EQ(streamed("a,b,x\r\n\"1\r\n\"\"2\",\"\n\",3\r\n4,\"\"\"\",6"), (std::vector<double>{3, 6}));
  EXPECT_EQ(streamed("\xEF\xBB\xBF\"a\nb\",x\n1,2\n"), std::vector<double>{2});
}

}  // namespace
}  // namespace truepose::config
