#pragma once

#include <cstdint>
#include <string>

namespace truepose::soak {

/// What a soak of campaigns came to. Broken invariants are reported as test failures where they break.
struct CampaignSoak {
  double hours = 0;  ///< of the cell
  int campaigns = 0, done = 0, aborted = 0, failed = 0;
  int points = 0, skipped = 0, troubles = 0;
  std::uint64_t hash = 0;  ///< of everything that happened, in order
};

/// Runs campaign after campaign in virtual time, against devices that misbehave and an operator who
/// interferes.
CampaignSoak soak_campaigns(std::uint64_t seed, double hours);

}  // namespace truepose::soak
