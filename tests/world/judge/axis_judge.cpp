#include "tests/world/judge/axis_judge.hpp"

#include <chrono>
#include <numbers>

#include "tests/world/judge/rsi_attribute.hpp"

namespace truepose::world {

using namespace std::chrono_literals;

namespace {

constexpr double kRad_per_deg = std::numbers::pi / 180;

/// How long an arm may still move after it came to this state.
drivers::Duration time_to_rest(const std::string& state) {
  if (state == "paused") return 5min;  // a point under way is measured, again where that fails
  if (state == "off") return 30s;      // the controller finds that its client is gone
  return 1500ms;
}

bool moves_the_arm(const std::string& state) {
  return state.empty() || state == "campaign" || state == "streaming" || state == "armed";
}

}  // namespace

void AxisJudge::see(const RsiCycle& cycle) {
  last_cycle_ = log_.now();
  // A fault lasts by cycles, which silences and restarts of the controller delay.
  if (cycle.datagram.empty() || log_.had_fault({"rsi-corrupted"}, 15s)) return;
  JointVector q_rad = JointVector::Zero(6);
  for (int i = 0; i < 6; ++i) {
    const auto deg = rsi_attribute(cycle.datagram, "AIPos", "A" + std::to_string(i + 1));
    if (!deg) return;
    q_rad[i] = *deg * kRad_per_deg;
  }
  judge_limits(q_rad, "at the RSI cable");
}

void AxisJudge::look(const std::string& state) {
  const JointVector q_rad = cell_.devices.axes();
  const std::string now = cell_.pc.runs() ? state : "off";
  judge_limits(q_rad, "in state " + now);
  judge_rest(q_rad, now);
}

void AxisJudge::judge_limits(const JointVector& q_rad, const std::string& where) {
  constexpr double kRounding_rad = 1e-6;
  for (std::size_t i = 0; i < cell_.scenario.nominal.joints.size(); ++i) {
    const Joint& joint = cell_.scenario.nominal.joints[i];
    const double q = q_rad[static_cast<Eigen::Index>(i)];
    if (q < joint.min - kRounding_rad || q > joint.max + kRounding_rad)
      log_.broken("axis " + std::to_string(i + 1) + " is at " + std::to_string(q / kRad_per_deg) +
                  " deg, beyond its software limits, " + where);
  }
}

void AxisJudge::judge_rest(const JointVector& q_rad, const std::string& state) {
  constexpr double kRest_rad = 1e-9;
  const double moved_rad = q_rad_.size() > 0 ? (q_rad - q_rad_).cwiseAbs().maxCoeff() : 0;
  const bool is_other_program = cell_.devices.program().name != "TRUEPOSE_MOTION";
  const bool is_rsi_on = log_.now() - last_cycle_ < 2s;
  const bool is_ordered = moves_the_arm(state) || is_other_program || is_rsi_on || log_.was_jogged(2s);
  if (state != state_ || is_ordered) may_move_until_ = log_.now() + time_to_rest(state);
  if (moved_rad > kRest_rad && log_.now() > may_move_until_)
    log_.broken("an axis moves by " + std::to_string(moved_rad / kRad_per_deg) + " deg in state " + state);
  state_ = state;
  q_rad_ = q_rad;
}

}  // namespace truepose::world
