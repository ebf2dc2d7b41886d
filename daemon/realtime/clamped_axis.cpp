#include "daemon/realtime/clamped_axis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace truepose::daemon {
namespace {

constexpr double kFollows_deg = 0.05;     // as StreamOptions::following_tolerance_rad
constexpr double kSameLimit_deg = 0.005;  // of measured corrections
constexpr double kRoundTo_deg = 0.05;

bool is_round(double deg) { return std::abs(std::remainder(deg, kRoundTo_deg)) <= kSameLimit_deg; }

}  // namespace

std::optional<ClampedAxis> clamped_axis(const StreamStatus& status) {
  std::array<std::optional<double>, 2> limits;  // below and above zero
  std::optional<ClampedAxis> worst;
  int clamped = 0;
  for (std::size_t i = 0; i < status.correction_deg.size(); ++i) {
    const double sent = status.correction_deg[i];
    if (!status.measured_deg[i]) return std::nullopt;
    const double stands = *status.measured_deg[i], lacks = std::abs(sent - stands);
    if (lacks <= kFollows_deg) continue;
    const bool short_of_it = sent * stands > 0 && std::abs(stands) < std::abs(sent);
    if (!short_of_it || std::abs(stands) < kFollows_deg) return std::nullopt;
    std::optional<double>& limit = limits[sent > 0];
    if (limit && std::abs(*limit - stands) > kSameLimit_deg) return std::nullopt;
    limit = stands;
    ++clamped;
    if (!worst || lacks > std::abs(worst->sent_deg - worst->stands_deg))
      worst = ClampedAxis{static_cast<int>(i) + 1, sent, stands};
  }
  if (clamped == 1 && !is_round(worst->stands_deg)) return std::nullopt;
  return worst;
}

}  // namespace truepose::daemon
