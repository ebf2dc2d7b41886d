#include "core/quality/splits_verdict.hpp"

#include <gtest/gtest.h>

namespace truepose {
namespace {

JudgedSplit split(std::uint64_t seed, std::vector<Finding> findings, double largest_mm = 0.1) {
  return {seed, {std::move(findings)}, largest_mm};
}
const Finding kDoubt{Severity::Warning, "a doubt"}, kRefusal{Severity::Error, "a refusal"},
    kNote{Severity::Note, "a note"}, kAdvice{Severity::Advice, "an advice"};

TEST(VerdictOverSplits, IsThatOfTheFirstWhereTheOthersAreSound) {
  const std::vector splits{split(3, {kAdvice, kNote}), split(4, {}), split(5, {kAdvice})};
  const CalibrationVerdict verdict = verdict_over_splits(splits, 0.2);
  EXPECT_EQ(verdict.color(), VerdictColor::Amber);
  ASSERT_EQ(verdict.findings.size(), 2U);
  EXPECT_EQ(verdict.findings[1].sentence, "a note");
}

TEST(VerdictOverSplits, IsRedWhereTheErrorsOfAnyAreBeyondTheTolerance) {
  const std::vector splits{split(3, {}, 0.1), split(4, {}, 2.5), split(5, {}, 0.3), split(6, {}, 0.2)};
  const CalibrationVerdict verdict = verdict_over_splits(splits, 0.2);
  EXPECT_EQ(verdict.color(), VerdictColor::Red);
  ASSERT_EQ(verdict.findings.size(), 1U);
  EXPECT_EQ(
      verdict.findings[0].sentence,
      "errors of 2 of the 4 splits are beyond the tolerance of 0.200 mm, the largest, 2.500 mm, in that of seed 4");
  EXPECT_EQ(verdict_over_splits(splits, 2.5).color(), VerdictColor::Green);
  EXPECT_EQ(verdict_over_splits(splits, std::nullopt).color(), VerdictColor::Green);
}

TEST(VerdictOverSplits, IsRedWhereAnyIsRefusedAndNamesItsSeed) {
  const std::vector splits{split(3, {kNote}), split(4, {kDoubt}), split(5, {kRefusal, kDoubt}),
                           split(6, {kRefusal})};
  const CalibrationVerdict verdict = verdict_over_splits(splits, std::nullopt);
  EXPECT_EQ(verdict.color(), VerdictColor::Red);
  EXPECT_EQ(verdict.findings.front().sentence,
            "2 of the 4 splits refuse the model, that of seed 5: a refusal");
}

TEST(VerdictOverSplits, IsDoubtedOnlyWhereMoreThanHalfRaiseDoubts) {
  std::vector splits{split(3, {kNote}), split(4, {kDoubt}), split(5, {}), split(6, {kDoubt})};
  CalibrationVerdict verdict = verdict_over_splits(splits, std::nullopt);
  EXPECT_EQ(verdict.color(), VerdictColor::Green);
  EXPECT_FALSE(verdict.failed());
  EXPECT_EQ(verdict.findings.back().sentence, "2 of the 4 splits raise doubts, that of seed 4: a doubt");

  splits[2] = split(5, {kDoubt});
  verdict = verdict_over_splits(splits, std::nullopt);
  EXPECT_EQ(verdict.color(), VerdictColor::Amber);
  EXPECT_TRUE(verdict.failed());
  EXPECT_EQ(verdict.findings.front().sentence, "3 of the 4 splits raise doubts, that of seed 4: a doubt");
}

TEST(VerdictOverSplits, SaysWhatAllHaveInCommonOnce) {
  const std::vector splits{split(3, {kDoubt}), split(4, {kDoubt}), split(5, {kDoubt})};
  EXPECT_EQ(verdict_over_splits(splits, std::nullopt).findings.size(), 1U);
}

}  // namespace
}  // namespace truepose
