// The cell in virtual time, for as long as one likes:
//   TRUEPOSE_SOAK_HOURS=1000 TRUEPOSE_SOAK_STREAM_HOURS=24 TRUEPOSE_SOAK_SEED=7 soak_test
// The same seed does the same again, event by event.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/soak/campaign_soak.hpp"
#include "tests/soak/stream_soak.hpp"
#include "tests/trials.hpp"

namespace truepose::soak {
namespace {

double number(const char* variable, double otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr ? otherwise : std::stod(text);
}

double hours() { return number("TRUEPOSE_SOAK_HOURS", all_trials() ? 20 : 4); }
double stream_hours() { return number("TRUEPOSE_SOAK_STREAM_HOURS", 1); }

std::uint64_t seed() {
  const char* text = std::getenv("TRUEPOSE_SOAK_SEED");
  return text == nullptr ? 20260519 : std::stoull(text);
}

TEST(CampaignSoak, KeepsItsPromisesThroughLostConnectionsBrokenBeamsRestartsAndOperators) {
  const CampaignSoak soak = soak_campaigns(seed(), hours());
  std::printf(
      "seed %llu: %.1f h of the cell, %d campaigns (%d done, %d aborted, %d failed), %d points, %d poses "
      "skipped, "
      "%d troubles, %d campaigns with spoiled data (%d biased models put to use), events %016llx\n",
      static_cast<unsigned long long>(seed()), soak.hours, soak.campaigns, soak.done, soak.aborted,
      soak.failed, soak.points, soak.skipped, soak.troubles, soak.spoiled, soak.biased_activated,
      static_cast<unsigned long long>(soak.hash));
  EXPECT_GE(soak.hours, hours());
  EXPECT_GT(soak.done, soak.campaigns / 2);
  EXPECT_GT(soak.troubles, 0);
  EXPECT_GT(soak.spoiled, 0);
}

TEST(CampaignSoak, TheSameSeedDoesTheSameAgainAndAnotherSeedDoesNot) {
  const CampaignSoak first = soak_campaigns(seed(), 1);
  const CampaignSoak again = soak_campaigns(seed(), 1);
  const CampaignSoak other = soak_campaigns(seed() + 1, 1);
  EXPECT_EQ(first.hash, again.hash);
  EXPECT_EQ(first.hours, again.hours);
  EXPECT_NE(first.hash, other.hash);
}

TEST(StreamSoak, KeepsItsPromisesThroughStrangersGapsBacklogsRestartsAndSilence) {
  const StreamSoak soak = soak_stream(seed(), stream_hours());
  const auto count = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "seed %llu: %.2f h of the stream in %d cells, %llu cycles (%llu heard, %llu answered in time), %llu "
      "sessions, %llu restarts of the daemon, %llu stalls, %llu silences, %llu foreign datagrams; largest "
      "step "
      "%.6f of the bound, corrections up to %.2f deg, replies %016llx\n",
      count(seed()), soak.hours, soak.cells, count(soak.cycles), count(soak.heard), count(soak.answered),
      count(soak.sessions), count(soak.restarts), count(soak.stalls), count(soak.silences),
      count(soak.foreign), soak.greatest_step, soak.greatest_correction_deg, count(soak.hash));
  EXPECT_GT(soak.answered, soak.heard / 2);
  EXPECT_GT(soak.greatest_correction_deg, 1);
  for (const std::uint64_t happened :
       {soak.sessions, soak.restarts, soak.stalls, soak.silences, soak.foreign})
    EXPECT_GT(happened, 2U);
}

TEST(StreamSoak, TheSameSeedGivesTheSameReplies) {
  const StreamSoak first = soak_stream(seed(), 0.02);
  EXPECT_EQ(soak_stream(seed(), 0.02).hash, first.hash);
  EXPECT_NE(soak_stream(seed() + 1, 0.02).hash, first.hash);
}

}  // namespace
}  // namespace truepose::soak
