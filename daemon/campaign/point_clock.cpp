#include "daemon/campaign/point_clock.hpp"

#include <algorithm>
#include <utility>

#include "core/data/measured_time.hpp"

namespace truepose::daemon {
namespace {

using std::chrono::system_clock;

std::optional<system_clock::time_point> time_of(const std::string& text) {
  const auto parsed = measured_time(text);
  if (!parsed || parsed->form != TimeForm::Zoned) return std::nullopt;
  return system_clock::time_point{
      std::chrono::round<system_clock::duration>(std::chrono::duration<double>{parsed->seconds})};
}

}  // namespace

PointClock::PointClock(drivers::WallClock wall_clock, const drivers::Clock& steady_clock,
                       const std::string& before)
    : wall_clock_{std::move(wall_clock)}, steady_clock_{steady_clock}, before_{time_of(before)} {}

system_clock::time_point PointClock::now() {
  if (!start_) {
    const system_clock::time_point wall = wall_clock_();
    start_ = {before_ ? std::max(wall, *before_) : wall, steady_clock_.now()};
  }
  return start_->wall +
         std::chrono::duration_cast<system_clock::duration>(steady_clock_.now() - start_->steady);
}

}  // namespace truepose::daemon
