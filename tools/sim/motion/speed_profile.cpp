#include "tools/sim/motion/speed_profile.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::sim {

SpeedProfile::SpeedProfile(const std::vector<SpeedLimit>& parts) {
  // Speeds where parts meet: no more than can be reached before and braked from behind.
  std::vector<double> speeds(parts.size() + 1, 0);
  const auto reached = [](double speed, const SpeedLimit& part) {
    return std::sqrt(speed * speed + 2 * part.acceleration_mm_s2 * part.length_mm);
  };
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    if (parts[i].stops) continue;
    speeds[i + 1] = std::min({parts[i].speed_mm_s, parts[i + 1].speed_mm_s, reached(speeds[i], parts[i])});
  }
  for (std::size_t i = parts.size(); i-- > 0;)
    speeds[i] = std::min(speeds[i], reached(speeds[i + 1], parts[i]));
  for (std::size_t i = 0; i < parts.size(); ++i) add(speeds[i], speeds[i + 1], parts[i]);
}

void SpeedProfile::add(double from_mm_s, double to_mm_s, const SpeedLimit& part) {
  if (part.length_mm <= 0) return;
  const double a = part.acceleration_mm_s2;
  const double squares = from_mm_s * from_mm_s + to_mm_s * to_mm_s;
  const double top = std::min(part.speed_mm_s, std::sqrt(a * part.length_mm + squares / 2));
  const double cruise_mm = std::max(0.0, part.length_mm - (2 * top * top - squares) / (2 * a));
  add_phase(from_mm_s, a, (top - from_mm_s) / a);
  add_phase(top, 0, cruise_mm / top);
  add_phase(top, -a, (top - to_mm_s) / a);
}

void SpeedProfile::add_phase(double speed_mm_s, double acceleration_mm_s2, double lasts_s) {
  if (lasts_s <= 0) return;
  phases_.push_back({.begins_s = duration().count(),
                     .begins_mm = length_mm(),
                     .speed_mm_s = speed_mm_s,
                     .acceleration_mm_s2 = acceleration_mm_s2,
                     .lasts_s = lasts_s});
}

Seconds SpeedProfile::duration() const {
  return Seconds{phases_.empty() ? 0 : phases_.back().begins_s + phases_.back().lasts_s};
}

double SpeedProfile::length_mm() const { return phases_.empty() ? 0 : phases_.back().end_mm(); }

double SpeedProfile::covered_mm(Seconds t) const {
  if (t >= duration()) return length_mm();
  const auto after = std::ranges::upper_bound(phases_, t.count(), {}, &Phase::begins_s);
  if (after == phases_.begin()) return 0;
  Phase until = after[-1];
  until.lasts_s = t.count() - until.begins_s;
  return until.end_mm();
}

Seconds SpeedProfile::time_at(double mm) const {
  if (mm >= length_mm()) return duration();
  const auto after = std::ranges::upper_bound(phases_, mm, {}, &Phase::begins_mm);
  if (after == phases_.begin()) return Seconds{0};
  const Phase& phase = after[-1];
  const double way = mm - phase.begins_mm, v = phase.speed_mm_s, a = phase.acceleration_mm_s2;
  // The root that does not lose digits, of a t^2 / 2 + v t = way.
  const double root = std::sqrt(std::max(0.0, v * v + 2 * a * way));
  return Seconds{phase.begins_s + (way > 0 ? 2 * way / (v + root) : 0)};
}

}  // namespace truepose::sim
