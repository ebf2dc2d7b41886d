// What the verdict says of sound campaigns, and what the transfer uncertainty counts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/statistics.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/core/quality/drawn_campaign.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

std::string worst_finding(const JudgedCampaign& made) {
  if (made.refused) return "refused: " + made.refusal;
  return made.verdict.findings.empty() ? "" : made.verdict.findings.front().sentence;
}

TEST(VerdictOnSoundCampaigns, IsNeverRedAndHardlyEverAmber) {
  const int runs = trials(1000);
  int green = 0, amber = 0, red = 0;
  std::vector<double> times;
  std::map<std::string, int> alarms;
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(run) + 1;
    const JudgedCampaign made = judged(sound_cell(seed), seed);
    const VerdictColor color = made.refused ? VerdictColor::Red : made.verdict.color();
    green += color == VerdictColor::Green;
    amber += color == VerdictColor::Amber;
    red += color == VerdictColor::Red;
    if (color != VerdictColor::Green) std::cout << "seed " << seed << ": " << worst_finding(made) << '\n';
    if (!made.refused) times.push_back(made.true_rms_mm / made.calibration.transfer.rms_mm);
    for (const Finding& found : made.verdict.findings) ++alarms[found.code];
  }
  std::ranges::sort(times);
  std::cout << green << " green, " << amber << " amber, " << red
            << " red; true over predicted elsewhere: " << median(times) << " in the median, "
            << times[times.size() * 19 / 20] << " at 95 %\n";
  EXPECT_EQ(red, 0);
  EXPECT_LE(amber, all_trials() ? 5 : 1);
  for (const FindingRow& row : kFindings) {
    const int found = alarms[std::string{row.code}];
    if (found > 0) std::cout << row.code << ": " << found << '\n';
    EXPECT_LE(found, std::ceil(row.most_false_alarms * runs)) << row.code;
  }
}

TEST(TransferUncertainty, CountsWhatTheModelLeavesOfAnArmThatBends) {
  for (const std::string_view arm : {"an arm that bends", "one with gears", "one with both"}) {
    std::vector<double> times;
    int failed = 0;
    for (int run = 0; run < trials(500); ++run) {
      const auto seed = static_cast<std::uint64_t>(run) + 5001;
      DrawnCell cell = sound_cell(seed);
      cell.nominal = example::kr210();
      cell.truth.robot = example::deviating(cell.nominal, cell.random, 0.3, 0.3e-3);
      cell.truth.non_geometric = heavy_arm_errors(
          {.compliance = arm != "one with gears", .harmonics = arm != "an arm that bends", .seed = seed});
      cell.warms = false;
      cell.truth.warm_up = {};
      cell.options.non_geometric = false;
      cell.options.field = FieldUse::None;
      cell.identify += 26;
      const JudgedCampaign made = judged(cell, seed);
      if (made.refused) {
        ++failed;
        continue;
      }
      failed += made.verdict.failed();
      times.push_back(made.true_rms_mm / made.calibration.transfer.rms_mm);
    }
    std::ranges::sort(times);
    std::cout << arm << ": true over predicted elsewhere " << median(times) << " in the median, "
              << times[times.size() * 19 / 20] << " at 95 %, failed " << failed << '\n';
    EXPECT_LT(median(times), 1.2) << arm;
    EXPECT_LT(times[times.size() * 19 / 20], 2) << arm;
  }
}

}  // namespace
}  // namespace truepose
