// What the readers do with texts of any size and of no sense.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <sstream>
#include <string>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "config/table/csv_reader.hpp"
#include "config/text_file.hpp"
#include "config/yaml_reader.hpp"
#include "tests/config/error_of.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/cpu_time.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;

std::string error(const std::function<void()>& read) {
  try {
    read();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

std::string yaml_error(const std::string& text) {
  return error([&] { parse_yaml(text, "f"); });
}

std::string csv_error(const std::string& text) {
  return error([&] { CsvTable::parse(text, "f"); });
}

std::string stream_error(const std::string& text) {
  return error([&] {
    std::istringstream in(text);
    CsvStream rows(in, "f");
    while (rows.next()) {
    }
  });
}

/// `count` times what `piece` makes of a number.
std::string repeated(int count, const std::function<std::string(const std::string&)>& piece) {
  std::string text;
  for (int i = 0; i < count; ++i) text += piece(std::to_string(i));
  return text;
}

/// That eight times as much takes about eight times as long; were all compared with all, it would be 64
/// times.
void expect_linear(const std::function<void(int)>& read, int size) {
  const double small = cpu_seconds([&] { read(size); });
  const double large = cpu_seconds([&] { read(8 * size); });
  EXPECT_LT(large / small, 20) << small << " s and " << large << " s";
}

TEST(YamlText, WithACommaInPlaceOfAValueIsRefused) {
  const std::string comma = "not valid YAML: a comma in place of a value";
  EXPECT_EQ(yaml_error(","), "f:1:1: " + comma);
  EXPECT_EQ(yaml_error(",q1,q2\n0,1,2\n"), "f:1:1: " + comma);  // as pandas writes its index
  EXPECT_EQ(yaml_error("--- ,"), "f:1:5: " + comma);
  EXPECT_EQ(yaml_error("# a comment\n,"), "f:2:1: " + comma);
  EXPECT_EQ(yaml_error("&anchor ,"), "f:1:9: " + comma);
  EXPECT_EQ(yaml_error("\"q1\",\"q2\""), "f:1:5: " + comma);
  EXPECT_EQ(yaml_error("a: 1\n--- ,"), "f:2:5: " + comma);
  EXPECT_THAT(yaml_error("a: 1\n,"), HasSubstr("not valid YAML"));
}

TEST(YamlText, ThatBeginsWithACommaIsRefusedAsAnyFileOfOurs) {
  const TempFolder folder;
  const auto file = folder.write("robot.yaml", ",q1\n");
  EXPECT_THAT(error([&] { load_robot(file); }), HasSubstr("robot.yaml:1:1: not valid YAML"));
}

TEST(YamlText, MayNameAValueAndStandForItAgain) {
  const YamlValue value = parse_yaml("a: &one 1\nb: [*one, *one]\n? *one\n: 2\n", "f");
  value.expect_keys({"a", "b", "1"});
  EXPECT_EQ(value.at("b").list().at(1).number({0, 5}), 1);
  EXPECT_EQ(value.at("1").number({0, 5}), 2);
  EXPECT_THAT(yaml_error("a: *none"), HasSubstr("not valid YAML"));
}

TEST(YamlText, IsReadInTimeInProportionToIt) {
  const auto keys = [](int count) {
    parse_yaml(repeated(count, [](const std::string& i) { return "key" + i + ": 1\n"; }), "f");
  };
  expect_linear(keys, 5000);
}

TEST(YamlText, HasAMostOfValuesAndBytes) {
  const auto item = [](const std::string&) { return std::string("- 1\n"); };
  EXPECT_THAT(yaml_error(repeated(100'001, item)), HasSubstr("too many or too deeply nested values"));
  // Before the tree has become larger than it may be.
  EXPECT_THAT(yaml_error(repeated(250'000, item)), HasSubstr("f:200000:3: too many"));
  const TempFolder folder;
  const auto file = folder.write("large.yaml", std::string(kMostBytesOfYaml + 1, ' '));
  EXPECT_THAT(error([&] { read_yaml(file); }), HasSubstr("large.yaml: has more than 16 MiB"));
}

TEST(YamlText, WithAHugeKeyIsComplainedOfInShort) {
  const std::string text =
      "? " + std::string(5000, 'k') + "\n: [" + repeated(1000, [](auto&) { return "1, "; }) + "x]";
  const YamlValue value = parse_yaml(text, "f");
  const std::string all = error([&] { value.expect_keys({"a"}); });
  EXPECT_LT(all.size(), 200u) << all;
}

TEST(CsvText, IsReadInTimeInProportionToIt) {
  const auto rows = [](int count) {
    CsvTable::parse("a,b,c\n" + repeated(count, [](const std::string& i) { return i + ",\"x\",1.5\n"; }),
                    "f");
  };
  expect_linear(rows, 5000);
  const auto stream = [](int count) {
    stream_error("a,b,c\n" + repeated(count, [](const std::string& i) { return i + ",\"x\",1.5\n"; }));
  };
  expect_linear(stream, 5000);
}

TEST(CsvText, HasAMostOfColumns) {
  const auto name = [](const std::string& i) { return "," + i; };
  const std::string most = "a" + repeated(999, name), more = most + ",b";
  EXPECT_EQ(csv_error(most + "\n" + most), "no error");
  EXPECT_EQ(csv_error(more), "f: line 1: more than 1000 columns");
  EXPECT_EQ(csv_error("a,b\n1,2\n" + std::string(80'000, ',')), "f: line 3: more than 1000 columns");
  EXPECT_EQ(stream_error(more), "f: line 1: more than 1000 columns");
}

TEST(CsvText, HasAMostOfRowsAndBytes) {
  EXPECT_EQ(csv_error("a\n" + repeated(1'000'001, [](auto&) { return "1\n"; })),
            "f: more than 1000000 rows of data");
  const TempFolder folder;
  const auto file = folder.write("large.csv", std::string(CsvTable::kMostBytes + 1, '\n'));
  EXPECT_THAT(error([&] { CsvTable::read(file); }), HasSubstr("large.csv: has more than 64 MiB"));
}

TEST(CsvText, OfAPipeHasAMostOfBytesInARow) {
  const std::string long_line(CsvStream::kMostBytesOfRow + 1, 'x');
  EXPECT_EQ(stream_error(long_line), "f: line 1: a row of more than 1 MiB");
  EXPECT_EQ(stream_error("a\n\"" + repeated(200'000, [](auto&) { return "open\n"; }) +
                         repeated(200'000, [](auto&) { return "open\n"; })),
            "f: line 2: a row of more than 1 MiB");
}

TEST(CsvText, GivesItsFieldsBackInWhateverOrderTheyAreAskedFor) {
  const CsvTable table = CsvTable::parse("a,b\n\"x,\ny\", z \n,\n1,\"\"\"\"\n", "f");
  ASSERT_EQ(table.row_count(), 3u);
  EXPECT_EQ(table.text(2, 1), "\"");
  EXPECT_EQ(table.text(0, 0), "x,\ny");
  EXPECT_EQ(table.text(0, 1), "z");
  EXPECT_EQ(table.text(1, 1), "");
  EXPECT_EQ(error([&] { static_cast<void>(table.number(2, 1)); }),
            "f: row 3 (line 5): b: not a number: '\"'");
}

TEST(MeasurementRows, HaveAMostOfReflectors) {
  const TempFolder folder;
  std::string text = "q1,q2,q3,q4,q5,q6,x,y,z,smr\n";
  text += repeated(101, [](const std::string& i) { return "0,0,0,0,0,0,1,2,3,r" + i + "\n"; });
  const auto file = folder.write("data.csv", text);
  EXPECT_THAT(error([&] { load_measurements(file, example::kr210()); }),
              HasSubstr("row 101 (line 102): smr: more than 100 reflectors in one file"));
}

TEST(AFile, ThatNeverEndsIsRefused) {
  EXPECT_THAT(error([] { read_bytes("/dev/zero", 1 << 20); }), HasSubstr("/dev/zero: has more than 1 MiB"));
}

}  // namespace
}  // namespace truepose::config
