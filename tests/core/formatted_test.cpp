#include "core/formatted.hpp"

#include <gtest/gtest.h>

namespace truepose {
namespace {

TEST(Formatted, KeepsASentenceOfAnyLengthToItsEnd) {
  EXPECT_EQ(formatted("none"), "none");
  const std::string file = std::string(2000, 'x') + "\u00e4.csv";
  EXPECT_EQ(formatted("%s: %d rows: measure again", file.c_str(), 7), file + ": 7 rows: measure again");
}

}  // namespace
}  // namespace truepose
