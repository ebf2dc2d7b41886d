#pragma once

#include <cstdint>
#include <string>

namespace truepose::soak {

/// What a soak of campaigns came to. Broken invariants are reported as test failures where they break.
struct CampaignSoak {
  double hours = 0;  ///< of the cell
  int campaigns = 0, done = 0, aborted = 0, failed = 0;
  int points = 0, skipped = 0, troubles = 0;
  int spoiled = 0;           ///< campaigns whose tracker's data were not to be trusted
  int biased_activated = 0;  ///< models of a tracker that was pushed on the way, and put to use
  std::uint64_t hash = 0;    ///< of everything that happened, in order
};

/// Runs campaign after campaign in virtual time, against devices that misbehave, a tracker that is pushed or
/// says what cannot be, a store and a computation that fail, and an operator who interferes.
CampaignSoak soak_campaigns(std::uint64_t seed, double hours);

}  // namespace truepose::soak
