#include "tools/sim/rsi_client.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/kinematics/angles.hpp"
#include "core/kinematics/forward.hpp"

namespace truepose::sim {
namespace {

/// Which axes keep their correction in a cycle without a valid reply.
std::array<bool, 6> axes_held(const rsi::EthernetConfig& ethernet) {
  std::array<bool, 6> held{};
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

}  // namespace

RsiClient::RsiClient(RsiSetup setup, StreamPath path, std::uint64_t first_ipoc)
    : setup_{std::move(setup)},
      codec_{setup_.ethernet},
      hold_on_{axes_held(setup_.ethernet)},
      path_{std::move(path)},
      first_ipoc_{first_ipoc},
      ipoc_{first_ipoc} {}

std::string_view RsiClient::begin_cycle() {
  if (counters_.cycles > 0) {
    ipoc_ += static_cast<std::uint64_t>(setup_.cycle.count());
    path_.advance(setup_.cycle);
  }
  open_[counters_.cycles % kRemembered] = true;
  ++counters_.cycles;
  reply_.reset();

  rsi::RobotFrame frame;
  frame.ipoc = ipoc_;
  const rsi::EthernetConfig& ethernet = setup_.ethernet;
  if (ethernet.sends("RIst")) frame.rist = flange_pose(setup_.nominal, axes());
  if (ethernet.sends("RSol")) frame.rsol = flange_pose(setup_.nominal, path_.position());
  if (ethernet.sends("AIPos")) frame.aipos_rad = to_axes(axes());
  if (ethernet.sends("ASPos")) frame.aspos_rad = to_axes(path_.position());
  if (ethernet.sends("Delay")) frame.delay = static_cast<std::int64_t>(counters_.late + counters_.lost);
  return rsi::encode_robot_frame(frame, buffer_).value_or(std::string_view{});
}

RsiClient::Verdict RsiClient::receive(std::string_view datagram) {
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
  apply(answered && reply_->axis_correction_rad ? *reply_->axis_correction_rad : held());
  if (answered) {
    ++counters_.answered;
    unanswered_in_a_row_ = 0;
    return reply_->stop.value_or(false) ? std::optional{RsiEnd::Left} : std::nullopt;
  }
  ++counters_.lost;
  return ++unanswered_in_a_row_ >= setup_.timeout_cycles ? std::optional{RsiEnd::Timeout} : std::nullopt;
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

JointVector RsiClient::axes() const { return path_.position() + to_joints(correction_rad_); }

}  // namespace truepose::sim
