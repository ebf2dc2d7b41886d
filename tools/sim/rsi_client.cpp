#include "tools/sim/rsi_client.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"

namespace truepose::sim {

StreamPath::StreamPath(RobotModel nominal, std::vector<JointVector> points, double speed_scale)
    : nominal_{std::move(nominal)}, points_{std::move(points)}, speed_scale_{speed_scale}, motion_{leg()} {}

JointMotion StreamPath::leg() const {
  return {nominal_, points_[from_], points_[(from_ + 1) % points_.size()], speed_scale_};
}

JointVector StreamPath::position() const { return motion_.position(on_leg_); }

void StreamPath::advance(Seconds dt) {
  on_leg_ += dt;
  if (on_leg_ < motion_.duration()) return;
  on_leg_ -= motion_.duration();
  from_ = (from_ + 1) % points_.size();
  motion_ = leg();
}

Servo::Servo(ServoSetup setup, Seconds cycle)
    : dead_cycles_{static_cast<std::size_t>(setup.dead_time / cycle)},
      dead_part_{setup.dead_time / cycle - static_cast<double>(dead_cycles_)},
      share_(static_cast<Eigen::Index>(setup.lag.size())),
      given_(dead_cycles_ + 2) {
  std::ranges::transform(setup.lag, share_.begin(), [cycle](Seconds lag) {
    return lag > Seconds{0} ? 1 - std::exp(-(cycle / lag)) : 1.0;
  });
}

void Servo::stand_at(const JointVector& q) {
  std::ranges::fill(given_, q);
  position_ = q;
}

const JointVector& Servo::follow(const JointVector& given) {
  newest_ = (newest_ + 1) % given_.size();
  given_[newest_] = given;
  const JointVector due =
      (1 - dead_part_) * given_ago(dead_cycles_) + dead_part_ * given_ago(dead_cycles_ + 1);
  if (share_.size() == 0) {
    position_ = due;
  } else {
    position_ += share_.cwiseProduct(due - position_);
  }
  return position_;
}

const JointVector& Servo::given_ago(std::size_t cycles) const {
  return given_[(newest_ + given_.size() - cycles) % given_.size()];
}

namespace {

/// Which axes keep their correction in a cycle without a valid reply.
std::array<bool, 6> axes_held(const RsiSetup& setup) {
  const rsi::EthernetConfig& ethernet = setup.ethernet;
  std::array<bool, 6> held{};
  if (setup.hold_on) {
    held.fill(*setup.hold_on);
    return held;
  }
  if (!ethernet.axis_correction) return held;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const std::string tag = *ethernet.axis_correction + ".A" + std::to_string(i + 1);
    const auto element = std::ranges::find(ethernet.receive, tag, &rsi::Element::tag);
    held[i] = element != ethernet.receive.end() && element->hold_on;
  }
  return held;
}

rsi::CartesianPose flange_pose(const RobotModel& nominal, const JointVector& q) {
  const Eigen::Isometry3d X_BF = forward_kinematics(nominal, q);
  const Eigen::Vector3d p = X_BF.translation();
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X_BF.linear());
  return {p.x(), p.y(), p.z(), abc_deg[0], abc_deg[1], abc_deg[2]};
}

rsi::Axes in_deg(const JointVector& q) {
  rsi::Axes axes = to_axes(q);
  for (double& axis : axes) axis *= kDegPerRad;
  return axes;
}

}  // namespace

RsiClient::RsiClient(RsiSetup setup, StreamPath path, std::uint64_t first_ipoc)
    : setup_{std::move(setup)},
      codec_{setup_.ethernet},
      hold_on_{axes_held(setup_)},
      names_{setup_.ethernet},
      datagram_{setup_.ethernet, setup_.decimals},
      path_{std::move(path)},
      servo_{setup_.servo, setup_.cycle},
      first_ipoc_{first_ipoc},
      ipoc_{first_ipoc} {
  servo_.stand_at(path_.position());
}

std::string_view RsiClient::begin_cycle() {
  if (std::exchange(fresh_, false)) {
    servo_.stand_at(path_.position());
  } else {
    ipoc_ += static_cast<std::uint64_t>(setup_.cycle.count());
    path_.advance(setup_.cycle);
    servo_.follow(path_.position() + to_joints(correction_rad_));
  }
  open_[counters_.cycles % kRemembered] = true;
  ++counters_.cycles;
  reply_.reset();
  return datagram_.write({.ipoc = ipoc_,
                          .rist = flange_pose(setup_.nominal, axes()),
                          .rsol = flange_pose(setup_.nominal, path_.position()),
                          .aipos_deg = in_deg(axes()),
                          .aspos_deg = in_deg(path_.position()),
                          .delay = delay()});
}

std::int64_t RsiClient::delay() const {
  if (setup_.consecutive_delay) return unanswered_in_a_row_;
  return static_cast<std::int64_t>(counters_.late + counters_.lost - unanswered_before_);
}

RsiClient::Verdict RsiClient::receive(std::string_view datagram) {
  for (std::string& name : names_.new_strangers(datagram)) strangers_.push_back(std::move(name));
  const auto reply = codec_.decode(datagram);
  if (!reply) {
    ++counters_.rejected;
    return {Reply::Rejected};
  }
  const auto step = static_cast<std::uint64_t>(setup_.cycle.count());
  const std::uint64_t cycles_ago = (ipoc_ - reply->ipoc) / step;
  const bool sent = reply->ipoc >= first_ipoc_ && reply->ipoc <= ipoc_ && (ipoc_ - reply->ipoc) % step == 0;
  if (!sent || cycles_ago >= kRemembered ||
      !std::exchange(open_[(counters_.cycles - 1 - cycles_ago) % kRemembered], false)) {
    ++counters_.wrong_ipoc;
    return {Reply::WrongIpoc};
  }
  if (cycles_ago > 0) {
    ++counters_.late;
    --counters_.lost;
    return {Reply::Late, cycles_ago};
  }
  reply_ = *reply;
  return {Reply::Valid};
}

std::optional<RsiEnd> RsiClient::end_cycle() {
  const bool answered = reply_.has_value();
  if (!setup_.ignores_correction && !ignoring_)
    apply(answered && reply_->axis_correction_rad ? *reply_->axis_correction_rad : held());
  if (answered) {
    ++counters_.answered;
    unanswered_in_a_row_ = 0;
    return reply_->stop.value_or(false) ? std::optional{RsiEnd::Left} : std::nullopt;
  }
  ++counters_.lost;
  ++unanswered_in_a_row_;
  const bool waits = !setup_.ethernet.only_send;
  return waits && unanswered_in_a_row_ >= setup_.timeout_cycles ? std::optional{RsiEnd::Timeout}
                                                                : std::nullopt;
}

void RsiClient::pass(std::uint64_t cycles) {
  ipoc_ += cycles * static_cast<std::uint64_t>(setup_.cycle.count());
  for (; cycles > 0; --cycles) servo_.follow(path_.position() + to_joints(correction_rad_));
  forget_open_cycles();
}

void RsiClient::restart(std::uint64_t pause_cycles, std::optional<std::uint64_t> ipoc) {
  ipoc_ = ipoc.value_or(ipoc_ + (pause_cycles + 1) * static_cast<std::uint64_t>(setup_.cycle.count()));
  correction_rad_ = {};
  counters_.correction_rad = 0;
  unanswered_in_a_row_ = 0;
  unanswered_before_ = counters_.late + counters_.lost;
  fresh_ = true;
  forget_open_cycles();
}

void RsiClient::jump_ipoc(std::int64_t by) {
  ipoc_ += static_cast<std::uint64_t>(by);
  forget_open_cycles();
}

RsiClient RsiClient::twin() const {
  constexpr std::uint64_t kOtherClock = 1'000'003;
  RsiSetup setup = setup_;
  setup.timeout_cycles = std::numeric_limits<int>::max();
  return {std::move(setup), path_, ipoc_ + kOtherClock};
}

/// Their replies are to a time stamp that is no whole number of cycles ago.
void RsiClient::forget_open_cycles() {
  open_.fill(false);
  first_ipoc_ = fresh_ ? ipoc_ : ipoc_ + static_cast<std::uint64_t>(setup_.cycle.count());
}

/// What HOLDON leaves of the correction in force.
rsi::Axes RsiClient::held() const {
  rsi::Axes held_rad = correction_rad_;
  for (std::size_t i = 0; i < held_rad.size(); ++i) {
    if (!hold_on_[i]) held_rad[i] = 0;
  }
  return held_rad;
}

void RsiClient::apply(const rsi::Axes& wanted_rad) {
  const double limit_rad = setup_.axis_corr_limit_rad;
  bool clamped = false;
  counters_.correction_rad = 0;
  for (std::size_t i = 0; i < wanted_rad.size(); ++i) {
    const double applied_rad = std::clamp(wanted_rad[i], -limit_rad, limit_rad);
    clamped |= applied_rad != wanted_rad[i];
    counters_.max_step_rad = std::max(counters_.max_step_rad, std::abs(applied_rad - correction_rad_[i]));
    correction_rad_[i] = applied_rad;
    counters_.correction_rad = std::max(counters_.correction_rad, std::abs(applied_rad));
  }
  counters_.clamped += clamped;
}

}  // namespace truepose::sim
