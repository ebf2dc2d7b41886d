#include "tools/sim/controller/rsi_client.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"

namespace truepose::sim {

StreamPath::StreamPath(RobotModel nominal, std::vector<JointVector> points, double speed_scale)
    : nominal_{std::move(nominal)},
      points_{std::move(points)},
      speed_scale_{speed_scale},
      motion_{leg()},
      position_{points_.front()} {}

JointMotion StreamPath::leg() const {
  return {nominal_, points_[from_], points_[(from_ + 1) % points_.size()], speed_scale_};
}

void StreamPath::advance(Seconds cycle, const JointVector&, const JointVector&) {
  on_leg_ += cycle;
  if (on_leg_ >= motion_.duration()) {
    on_leg_ -= motion_.duration();
    from_ = (from_ + 1) % points_.size();
    motion_ = leg();
  }
  position_ = motion_.position(on_leg_);
}

FlowSources StreamPath::sources() const {
  return {.sen_pint = [](int) { return 1; }};
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

RsiFlow flow_of(const rsi::Context& context) {
  auto flow = RsiFlow::of(context);
  if (!flow) throw std::invalid_argument{flow.error()};
  return *std::move(flow);
}

rsi::CartesianPose flange_pose(const RobotModel& nominal, const JointVector& q) {
  const Eigen::Isometry3d X_BF = forward_kinematics(nominal, q);
  const Eigen::Vector3d p = X_BF.translation();
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X_BF.linear());
  return {p.x(), p.y(), p.z(), abc_deg[0], abc_deg[1], abc_deg[2]};
}

rsi::Axes in_deg(const JointVector& q) {
  rsi::Axes axes;
  std::ranges::transform(q, axes.begin(), [](double axis) { return axis * kDegPerRad; });
  return axes;
}

JointVector joints_of(const rsi::Axes& axes_rad) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 1>>(axes_rad.data());
}

}  // namespace

RsiClient::RsiClient(RsiSetup setup, std::shared_ptr<RsiProgram> program, std::uint64_t first_ipoc)
    : setup_{std::move(setup)},
      flow_{flow_of(setup_.context)},
      timeout_cycles_{flow_.timeout_cycles()},
      replies_{setup_.ethernet},
      datagram_{setup_.ethernet, flow_.decimals()},
      program_{std::move(program)},
      servo_{setup_.servo, setup_.cycle},
      first_ipoc_{first_ipoc},
      ipoc_{first_ipoc} {
  servo_.stand_at(program_->set_points());
  if (setup_.context.of_type("POSCORR") == nullptr) return;
  auto inverse = StatusTurnInverse::of(setup_.nominal);
  if (!inverse) throw std::invalid_argument{"POSCORR: " + inverse.error()};
  inverse_ = *std::move(inverse);
}

std::string_view RsiClient::begin_cycle() {
  if (std::exchange(fresh_, false)) {
    servo_.stand_at(program_->set_points());
  } else {
    ipoc_ += static_cast<std::uint64_t>(setup_.cycle.count());
    program_->advance(setup_.cycle, axes(), given() - program_->set_points());
    if (!program_->is_on()) return {};
    follow();
  }
  open_[counters_.cycles % kRemembered] = true;
  ++counters_.cycles;
  reply_.reset();
  return datagram_.write({.ipoc = ipoc_,
                          .rist = flange_pose(setup_.nominal, axes()),
                          .rsol = flange_pose(setup_.nominal, program_->set_points()),
                          .aipos_deg = in_deg(axes()),
                          .aspos_deg = in_deg(program_->set_points()),
                          .delay = delay(),
                          .inputs = flow_.sent(program_->sources())});
}

void RsiClient::follow() {
  if (program_->drives_on()) servo_.follow(given());
}

/// To the drives.
JointVector RsiClient::given() const { return set_points_in_force() + joints_of(correction_rad_); }

/// With the TCP corrected; as programmed where the arm does not reach that.
JointVector RsiClient::set_points_in_force() const {
  const JointVector& q = program_->set_points();
  if (!pose_correction_) return q;
  const FlowSources sources = program_->sources();
  const Eigen::Isometry3d X = forward_kinematics(setup_.nominal, q) * sources.tool;
  const Eigen::Isometry3d X_BF = pose_correction_->applied_to(X, sources.base) * inverse_of(sources.tool);
  return inverse_->solve(X_BF, std::nullopt, std::nullopt, q).value_or(q);
}

std::int64_t RsiClient::delay() const {
  if (setup_.consecutive_delay) return unanswered_in_a_row_;
  return static_cast<std::int64_t>(counters_.late + counters_.lost - unanswered_before_);
}

RsiClient::Verdict RsiClient::receive(std::string_view datagram) {
  if (setup_.ethernet.only_send) return {Reply::Unread};
  auto reply = replies_.read(datagram);
  if (!reply) {
    ++counters_.rejected;
    reject(std::move(reply).error());
    return {Reply::Rejected};
  }
  const auto step = static_cast<std::uint64_t>(setup_.cycle.count());
  const std::uint64_t cycles_ago = (ipoc_ - reply->ipoc) / step;
  const bool sent = reply->ipoc >= first_ipoc_ && reply->ipoc <= ipoc_ && (ipoc_ - reply->ipoc) % step == 0;
  if (!sent || cycles_ago >= kRemembered ||
      !std::exchange(open_[(counters_.cycles - 1 - cycles_ago) % kRemembered], false)) {
    ++counters_.wrong_ipoc;
    const std::string is = "IPOC is " + std::to_string(reply->ipoc);
    if (sent) {
      reject({ReplyFault::Cause::AnsweredBefore,
              is + ", which was answered before. Send one reply for each packet."});
    } else {
      reject({ReplyFault::Cause::OtherIpoc,
              is + ", the packet has " + std::to_string(ipoc_) + ". Copy it unchanged."});
    }
    return {Reply::WrongIpoc};
  }
  if (cycles_ago > 0) {
    ++counters_.late;
    --counters_.lost;
    return {Reply::Late, cycles_ago};
  }
  reply_ = *std::move(reply);
  return {Reply::Valid};
}

void RsiClient::reject(ReplyFault fault) {
  if (rejected_by_.insert(fault.cause).second) rejections_.push_back(std::move(fault.text));
}

/// To which the next corrections are added.
FlowEffects RsiClient::total() const {
  FlowEffects total;
  if (!program_->is_relative()) return total;
  std::ranges::transform(correction_rad_, total.correction_deg.begin(),
                         [](double axis) { return axis * kDegPerRad; });
  total.pose_correction = pose_correction_;
  return total;
}

std::optional<RsiEnd> RsiClient::end_cycle() {
  hold();
  if (reply_) {
    for (const auto& [channel, value] : reply_->outputs) outputs_[channel] = value;
    ++counters_.answered;
    unanswered_in_a_row_ = 0;
  } else if (!setup_.ethernet.only_send) {
    ++counters_.lost;
    ++unanswered_in_a_row_;
  }
  const FlowEffects effects = flow_.effects(program_->sources(), outputs_, total());
  if (!setup_.ignores_correction && !ignoring_ && program_->corrects()) {
    counters_.clamped += effects.clamped;
    rsi::Axes correction_rad;
    std::ranges::transform(effects.correction_deg, correction_rad.begin(),
                           [](double axis) { return axis * kRadPerDeg; });
    apply(correction_rad);
    pose_correction_ = effects.pose_correction;
  }
  program_->take(effects);
  if (effects.monitor_axis) return RsiEnd::Monitor;
  if (effects.monitor_pose) return RsiEnd::PoseMonitor;
  if (unanswered_in_a_row_ >= timeout_cycles_) return RsiEnd::Timeout;
  return program_->is_on() ? std::nullopt : std::optional{RsiEnd::Off};
}

void RsiClient::pass() {
  ipoc_ += static_cast<std::uint64_t>(setup_.cycle.count());
  program_->stand(setup_.cycle);
  follow();
  forget_open_cycles();
}

void RsiClient::restart(std::uint64_t pause_cycles, std::optional<std::uint64_t> ipoc) {
  ipoc_ = ipoc.value_or(ipoc_ + (pause_cycles + 1) * static_cast<std::uint64_t>(setup_.cycle.count()));
  outputs_.clear();
  correction_rad_ = {};
  pose_correction_.reset();
  counters_.correction_rad = 0;
  unanswered_in_a_row_ = 0;
  unanswered_before_ = counters_.late + counters_.lost;
  rejected_by_.clear();
  fresh_ = true;
  forget_open_cycles();
}

void RsiClient::jump_ipoc(std::int64_t by) {
  ipoc_ += static_cast<std::uint64_t>(by);
  forget_open_cycles();
}

RsiClient RsiClient::twin(std::int64_t ipoc_by) const {
  constexpr std::int64_t kFar = 1'000'003;
  const auto ahead = static_cast<std::uint64_t>(ipoc_by != 0 ? ipoc_by : kFar);
  const auto standing = std::make_shared<StreamPath>(setup_.nominal, std::vector{program_->set_points()}, 1);
  RsiClient twin{setup_, standing, ipoc_ + ahead};
  twin.timeout_cycles_ = std::numeric_limits<int>::max();
  return twin;
}

/// Their replies are to a time stamp that is no whole number of cycles ago.
void RsiClient::forget_open_cycles() {
  open_.fill(false);
  first_ipoc_ = fresh_ ? ipoc_ : ipoc_ + static_cast<std::uint64_t>(setup_.cycle.count());
}

/// Outputs without HOLDON last for one cycle.
void RsiClient::hold() {
  for (const rsi::Element& element : setup_.ethernet.receive) {
    if (element.index && !setup_.hold_on.value_or(element.hold_on)) outputs_.erase(*element.index);
  }
}

void RsiClient::apply(const rsi::Axes& correction_rad) {
  counters_.correction_rad = 0;
  for (std::size_t i = 0; i < correction_rad.size(); ++i) {
    counters_.max_step_rad =
        std::max(counters_.max_step_rad, std::abs(correction_rad[i] - correction_rad_[i]));
    counters_.correction_rad = std::max(counters_.correction_rad, std::abs(correction_rad[i]));
  }
  correction_rad_ = correction_rad;
}

}  // namespace truepose::sim
