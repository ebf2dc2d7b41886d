#include "daemon/campaign/campaign_observer.hpp"

#include <array>

namespace truepose::daemon {

std::string_view phase_name(CampaignPhase phase) {
  constexpr std::array<std::string_view, 10> names{"connecting", "computing", "warming_up",  "identifying",
                                                   "validating", "computing", "remeasuring", "correcting",
                                                   "cycling",    "activating"};
  return names[static_cast<std::size_t>(phase)];
}

}  // namespace truepose::daemon
