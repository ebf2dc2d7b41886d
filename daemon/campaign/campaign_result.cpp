#include "daemon/campaign/campaign_result.hpp"

#include <array>

namespace truepose::daemon {

std::string_view kind_name(CampaignKind kind) {
  constexpr std::array<std::string_view, 4> kNames{"calibration", "drift", "targets", "iso9283"};
  return kNames[static_cast<std::size_t>(kind)];
}

}  // namespace truepose::daemon
