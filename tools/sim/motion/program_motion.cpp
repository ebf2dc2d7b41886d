#include "tools/sim/motion/program_motion.hpp"

#include <algorithm>
#include <utility>

namespace truepose::sim {
namespace {

constexpr int kReducedPercent = 10;
constexpr double kReduced_m_s = 0.25;

void reduce(krl::Motion& motion) {
  for (int& percent : motion.velocity_percent) percent = std::min(percent, kReducedPercent);
  motion.path_velocity_m_s = std::min(motion.path_velocity_m_s.value_or(kReduced_m_s), kReduced_m_s);
  std::ranges::for_each(motion.segments, reduce);
}

}  // namespace

std::expected<ProgramMotion, std::string> ProgramMotion::of(const RobotModel& nominal, const JointVector& q) {
  auto planner = MotionPlanner::of(nominal);
  if (!planner) return std::unexpected(planner.error());
  return ProgramMotion{*std::move(planner), q};
}

std::expected<void, std::string> ProgramMotion::take(krl::Motion motion, bool reduced) {
  if (reduced) reduce(motion);
  auto planned = planner_.plan(motion, end_);
  if (!planned) return std::unexpected(planned.error());
  if (waiting_.empty()) since_ = blended_in_ = Seconds{0};
  end_ = planned->target;
  waiting_.push_back(*std::move(planned));
  const bool is_too_late = waiting_.size() == 2 && into_next();
  if (is_too_late) waiting_.front().blended = Seconds{0};
  return {};
}

bool ProgramMotion::is_finished(std::uint64_t motion) const {
  return std::ranges::none_of(waiting_,
                              [motion](const PlannedMotion& planned) { return planned.number == motion; });
}

void ProgramMotion::cancel() {
  waiting_.clear();
  end_ = q_;
  braked_ = false;
  rate_ = override_;
}

void ProgramMotion::place(const JointVector& q) {
  q_ = q;
  cancel();
}

std::optional<Seconds> ProgramMotion::until_change(Seconds cycle) const {
  if (switching_.is_waiting()) return cycle;
  if (is_standing()) return std::nullopt;
  const double wanted = braked_ ? 0 : override_;
  if (rate_ != wanted) return cycle;
  if (rate_ == 0) return std::nullopt;
  const PlannedMotion& motion = waiting_.front();
  const Seconds left = (motion.duration - since_) / rate_;
  const bool in_one_step = !motion.along && motion.blended <= Seconds{0} && motion.switches.empty();
  return in_one_step ? left : std::min(left, cycle);
}

const JointVector& ProgramMotion::advance(Seconds cycle) {
  const double change = cycle / kBraking, wanted = braked_ ? 0 : override_;
  rate_ = wanted > rate_ ? std::min(rate_ + change, wanted) : std::max(rate_ - change, wanted);
  switching_.pass(cycle);
  if (!waiting_.empty()) move_on(rate_ * cycle);
  return q_;
}

void ProgramMotion::move_on(Seconds time) {
  since_ += time;
  PlannedMotion& motion = waiting_.front();
  const auto into_next = this->into_next();
  const auto in_next = [&] { return waiting_[1].path(*into_next).value_or(motion.target); };
  switching_.visit(motion, since_, blended_in_, blended_out(), rate_);
  if (since_ < motion.duration) {
    q_ = motion.path(since_).value_or(q_);
    if (into_next) q_ += in_next() - motion.target;
    return;
  }
  switching_.leave(motion, waiting_.size() > 1 ? &waiting_[1] : nullptr);
  q_ = into_next ? in_next() : motion.target;
  since_ = blended_in_ = into_next.value_or(Seconds{0});
  moved_ += motion.moves_arm;
  waiting_.pop_front();
  ++made_;
  if (!waiting_.empty()) switching_.visit(waiting_.front(), since_, blended_in_, blended_out(), rate_);
}

/// How long the motion's end overlaps the beginning of the next.
Seconds ProgramMotion::blended_out() const {
  const PlannedMotion& motion = waiting_.front();
  if (waiting_.size() < 2) return Seconds{0};
  return std::min({motion.blended, motion.duration / 2, waiting_[1].duration / 2});
}

/// How long the next motion has been blended in; none where it has not begun.
std::optional<Seconds> ProgramMotion::into_next() const {
  if (blended_out() <= Seconds{0}) return std::nullopt;
  const Seconds into = since_ - (waiting_.front().duration - blended_out());
  return into > Seconds{0} ? std::optional{into} : std::nullopt;
}

}  // namespace truepose::sim
