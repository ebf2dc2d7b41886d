#include "tools/sim/motion/switching_points.hpp"

#include <algorithm>
#include <utility>

namespace truepose::sim {
namespace {

Seconds anchor_of(const PlannedMotion& motion, const PlannedSwitch& point, Seconds blended_in,
                  Seconds blended_out) {
  switch (point.anchor) {
    case PlannedSwitch::Anchor::Start:
      return blended_in;
    case PlannedSwitch::Anchor::End:
      return motion.duration - blended_out / 2;  // the middle of the arc
    case PlannedSwitch::Anchor::Inside:
      return point.inside;
  }
  return Seconds{0};
}

/// On the motion's own path; above its length where the next motion's has it.
double way_mm(const PlannedMotion& motion, const PlannedSwitch& point) {
  return motion.along->covered_mm(anchor_of(motion, point, Seconds{0}, Seconds{0})) + point.path_mm;
}

}  // namespace

void SwitchingPoints::visit(PlannedMotion& motion, Seconds into, Seconds blended_in, Seconds blended_out,
                            double rate) {
  std::erase_if(motion.switches, [&](const PlannedSwitch& point) {
    const bool is_shifted = point.path_mm != 0;
    if (is_shifted && way_mm(motion, point) > motion.along->length_mm()) return false;
    const Seconds at = is_shifted ? motion.along->time_at(way_mm(motion, point))
                                  : anchor_of(motion, point, blended_in, blended_out);
    if (into < at + rate * std::min(point.delay, Seconds{0})) return false;
    come_to(point);
    return true;
  });
}

void SwitchingPoints::leave(PlannedMotion& motion, PlannedMotion* next) {
  for (PlannedSwitch& point : std::exchange(motion.switches, {})) {
    const double beyond_mm = motion.along ? way_mm(motion, point) - motion.along->length_mm() : 0;
    if (beyond_mm <= 0 || !next || !next->along) {
      come_to(point);
      continue;
    }
    point.anchor = PlannedSwitch::Anchor::Start;
    point.path_mm = beyond_mm;
    next->switches.push_back(point);
  }
}

void SwitchingPoints::pass(Seconds time) {
  for (Delayed& delayed : delayed_) delayed.left -= time;
  std::erase_if(delayed_, [&](const Delayed& delayed) {
    if (delayed.left > Seconds{0}) return false;
    switched_.push_back(delayed.number);
    return true;
  });
}

std::vector<std::uint64_t> SwitchingPoints::take() { return std::exchange(switched_, {}); }

void SwitchingPoints::come_to(const PlannedSwitch& point) {
  if (point.delay > Seconds{0}) {
    delayed_.push_back({point.number, point.delay});
  } else {
    switched_.push_back(point.number);
  }
}

}  // namespace truepose::sim
