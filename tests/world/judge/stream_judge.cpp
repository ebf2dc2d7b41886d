#include "tests/world/judge/stream_judge.hpp"

#include <algorithm>
#include <cmath>

#include "tests/world/judge/rsi_attribute.hpp"

namespace truepose::world {

namespace {

/// Half a digit of the four that are sent, twice.
constexpr double kRounding_deg = 1.01e-4;
// A correction that moves nothing is held after 2 s (docs/stream.md); so many cycles are enough for what the
// lag of the drives hides at first.
constexpr int kNoticed = 2500;
constexpr double kMuch_deg = 0.1, kHeld_deg = 0.01;

}  // namespace

void StreamJudge::see(const RsiCycle& cycle) {
  ++cycles;
  const auto [known, is_new] = sessions_.try_emplace(cycle.session);
  if (is_new) ++sessions;
  Session& session = known->second;
  const auto where = [&] {
    return "session " + std::to_string(cycle.session) + ", cycle " + std::to_string(cycles);
  };
  for (std::size_t i = 0; i < session.sent_deg.size(); ++i) {
    if (cycle.reply.empty()) break;  // the controller holds what it has
    const auto deg = rsi_attribute(cycle.reply, "AK", "A" + std::to_string(i + 1));
    if (!deg) {
      broken.push_back(where() + ": a reply without axis " + std::to_string(i + 1));
      break;
    }
    double step = std::abs(*deg - session.sent_deg[i]);
    // Of replies that move nothing a new start begins with what the arm has.
    if (cycle.ignored) step = std::min(step, std::abs(*deg - session.moved_deg[i]));
    if (step > max_step_deg_ + kRounding_deg)
      broken.push_back(where() + ": axis " + std::to_string(i + 1) + " steps by " + std::to_string(step) +
                       " deg");
    largest_step_deg = std::max(largest_step_deg, step);
    session.sent_deg[i] = *deg;
  }
  judge_effect(cycle, session, where());
  if (cycle.end != sim::RsiEnd::Off) return;
  left_deg = 0;
  for (const double deg : session.sent_deg) left_deg = std::max(left_deg, std::abs(deg));
}

/// A correction of which much has moved nothing for long is held.
void StreamJudge::judge_effect(const RsiCycle& cycle, Session& session, const std::string& where) {
  const auto difference_deg = [&](const Axes& other_deg) {
    double largest = 0;
    for (std::size_t i = 0; i < other_deg.size(); ++i)
      largest = std::max(largest, std::abs(session.sent_deg[i] - other_deg[i]));
    return largest;
  };
  if (!cycle.ignored) session.moved_deg = session.sent_deg;
  const bool is_missing =
      cycle.ignored && !cycle.reply.empty() && difference_deg(session.moved_deg) > kMuch_deg;
  session.ignored = is_missing ? session.ignored + 1 : 0;
  if (session.ignored == kNoticed) session.held_deg = session.sent_deg;
  if (session.ignored > kNoticed && difference_deg(session.held_deg) > kHeld_deg)
    broken.push_back(where + ": a correction that moves nothing is not held");
}

}  // namespace truepose::world
