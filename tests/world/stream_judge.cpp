#include "tests/world/stream_judge.hpp"

#include <algorithm>
#include <cmath>

#include "tests/world/rsi_attribute.hpp"

namespace truepose::world {

namespace {

/// Half a digit of the four that are sent, twice.
constexpr double kRounding_deg = 1.01e-4;
// A correction that moves nothing is held after 2 s (docs/stream.md). So many cycles are long enough for what
// the lag of the drives hides at first.
constexpr int kNoticed = 2500;
constexpr double kLarge_deg = 0.1;

}  // namespace

void StreamJudge::see(const RsiCycle& cycle) {
  ++cycles;
  const auto [session, is_new] = in_effect_deg_.try_emplace(cycle.session);
  if (is_new) ++sessions;
  Axes& in_effect_deg = session->second;
  const auto where = [&] {
    return "session " + std::to_string(cycle.session) + ", cycle " + std::to_string(cycles);
  };
  double step_deg = 0;
  for (std::size_t i = 0; i < in_effect_deg.size(); ++i) {
    if (cycle.reply.empty()) break;  // the controller holds what it has
    const auto deg = rsi_attribute(cycle.reply, "AK", "A" + std::to_string(i + 1));
    if (!deg) {
      broken.push_back(where() + ": a reply without axis " + std::to_string(i + 1));
      break;
    }
    const double step = std::abs(*deg - in_effect_deg[i]);
    if (step > max_step_deg_ + kRounding_deg)
      broken.push_back(where() + ": axis " + std::to_string(i + 1) + " steps by " + std::to_string(step) +
                       " deg");
    step_deg = std::max(step_deg, step);
    largest_deg = std::max(largest_deg, std::abs(*deg));
    in_effect_deg[i] = *deg;
  }
  largest_step_deg = std::max(largest_step_deg, step_deg);
  const double largest_deg_now =
      std::abs(*std::ranges::max_element(in_effect_deg, {}, [](double deg) { return std::abs(deg); }));
  ignored_ = cycle.ignored && !cycle.reply.empty() && largest_deg_now > kLarge_deg ? ignored_ + 1 : 0;
  if (ignored_ > kNoticed && step_deg > kRounding_deg)
    broken.push_back(where() + ": a correction that moves nothing is not held");
  if (cycle.end != sim::RsiEnd::Off) return;
  for (const double deg : in_effect_deg) largest_left_deg = std::max(largest_left_deg, std::abs(deg));
}

}  // namespace truepose::world
