#include "core/quality/finding_kinds.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace truepose {
namespace {

using ::testing::HasSubstr;

TEST(FindingKinds, HaveACodeOfTheirOwnAConditionAndASourceOfItsThreshold) {
  std::set<std::string_view> codes;
  for (const FindingRow& row : kFindings) {
    EXPECT_TRUE(codes.insert(row.code).second) << row.code;
    EXPECT_TRUE(row.code.starts_with("V_")) << row.code;
    EXPECT_FALSE(row.condition.empty() || row.source.empty()) << row.code;
    EXPECT_FALSE(row.what_to_do.ends_with('.')) << row.code;
    // What asks for a look or forbids a model says what to do, and is seldom said of a sound campaign.
    if (row.severity == Severity::Note) continue;
    EXPECT_FALSE(row.what_to_do.empty()) << row.code;
    EXPECT_LE(row.most_false_alarms, 0.01) << row.code;
  }
}

TEST(FindingKinds, StandInTheTablesOfThePageAndNoOthersDo) {
  std::ifstream file{std::filesystem::path{TRUEPOSE_SOURCE_DIR} / "docs/verdict.md"};
  const std::string page{std::istreambuf_iterator<char>{file}, {}};
  std::size_t rows = 0;
  for (std::size_t at = page.find("\n| `V_"); at != std::string::npos; at = page.find("\n| `V_", at + 1))
    ++rows;
  EXPECT_EQ(rows, kFindings.size());
  for (const FindingRow& row : kFindings)
    EXPECT_THAT(page, HasSubstr("\n| `" + std::string{row.code} + "` | " +
                                std::string{name_of(kSeverityNames, row.severity)} + " | " +
                                std::string{row.condition} + " |\n"));
}

}  // namespace
}  // namespace truepose
