#include "core/data/measured_time.hpp"

#include <gtest/gtest.h>

#include "core/fit/warm_up.hpp"

namespace truepose {
namespace {

double seconds(std::string_view text) {
  const auto time = measured_time(text);
  EXPECT_TRUE(time) << text;
  return time ? time->seconds : -1;
}

TEST(MeasuredTime, IsReadFromDatesOfIso8601WithAndWithoutAZone) {
  // date -u -d 2026-11-26T08:00:30Z +%s
  constexpr double kThen = 1795680030;
  for (const char* text : {"2026-11-26T08:00:30Z", "2026-11-26t08:00:30z", "2026-11-26 08:00:30Z",
                           "2026-11-26T09:00:30+01:00", "2026-11-26T13:30:30+0530",
                           "2026-11-26T03:30:30-04:30", "2026-11-26T08:00:30", "2026-11-26 08:00:30"})
    EXPECT_EQ(seconds(text), kThen) << text;
  EXPECT_NEAR(seconds("2026-11-26T08:00:30.125Z"), kThen + 0.125, 1e-6);
  EXPECT_NEAR(seconds("2026-11-26T08:00:30.9"), kThen + 0.9, 1e-6);
  EXPECT_EQ(seconds("2024-02-29T00:00:00Z") + 86400, seconds("2024-03-01T00:00:00Z"));
}

TEST(MeasuredTime, IsReadFromSecondsSinceWhenever) {
  for (const auto& [text, expected] :
       {std::pair{"0", 0.0}, {"30.5", 30.5}, {"-12", -12.0}, {"1790000030", 1790000030.0}})
    EXPECT_EQ(seconds(text), expected);
}

TEST(MeasuredTime, SaysInWhichFormItWasGiven) {
  EXPECT_EQ(measured_time("30")->form, TimeForm::Number);
  EXPECT_EQ(measured_time("2026-11-26 08:00:30")->form, TimeForm::Local);
  EXPECT_EQ(measured_time("2026-11-26 08:00:30+01:00")->form, TimeForm::Zoned);
}

TEST(MeasuredTime, IsNotGuessedFromAnythingElse) {
  for (const char* text : {"",
                           "x12",
                           "08:00:30",
                           "26.11.2026 08:00:00",
                           "11/26/2026 08:00:00 AM",
                           "11-12-2026 08:00:00",
                           "2026-11-26",
                           "2026-11-26T08:00",
                           "2026-11-26T08:00:",
                           "2026-11-26T08:00:30.",
                           "2026-11-26T08:00:30 Z",
                           "2026-11-26T08:00:30+1",
                           "2026-11-26T08:00:30x",
                           " 30",
                           "30 s",
                           "inf",
                           "nan",
                           "1790000030000",
                           "2026-02-30T08:00:30",
                           "2026-13-01T08:00:30",
                           "2026-11-26T24:00:30",
                           "2026-11-26T08:60:30",
                           "20a6-11-26T08:00:30"})
    EXPECT_FALSE(measured_time(text)) << text;
}

TEST(MeasuredTime, TellsTheSameWarmthInEveryForm) {
  const auto warmth = [](std::vector<std::string> times) {
    MeasurementData data{.smr_names = {"1"}};
    for (std::string& time : times)
      data.points.push_back({.q = JointVector::Zero(1), .p_WS_mm = {1, 2, 3}, .time = std::move(time)});
    EXPECT_TRUE(has_times(data.points));
    data = with_warmth_by({.constant = 600}, std::move(data));
    return std::vector{data.points[0].temperature_c, data.points[1].temperature_c,
                       data.points[2].temperature_c};
  };
  const auto expected = warmth({"2026-11-26T08:05:00Z", "2026-11-26T08:00:00Z", "2026-11-26T08:20:00Z"});
  EXPECT_EQ(expected[1], std::vector{0.0});
  EXPECT_EQ(warmth({"2026-11-26 08:05:00", "2026-11-26 08:00:00", "2026-11-26 08:20:00"}), expected);
  EXPECT_EQ(warmth({"300", "0", "1200"}), expected);
  EXPECT_EQ(warmth({"1795680300", "1795680000", "1795681200"}), expected);
}

}  // namespace
}  // namespace truepose
