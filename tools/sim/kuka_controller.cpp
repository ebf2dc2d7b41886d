#include "tools/sim/kuka_controller.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"

namespace truepose::sim {
namespace {

/// Time to full speed at an acceleration of 100 %.
constexpr Seconds kFullSpeedAfter{0.5};

/// Values that EKI buffers for the program before it loses some (BUFFERING Limit).
constexpr std::size_t kBufferedCommands = 16;

constexpr int kMaxOverridePercent = 100;

SimTime to_sim_time(Seconds t) { return std::chrono::ceil<SimTime>(t); }

}  // namespace

eki::Axes to_axes(const JointVector& q) {
  eki::Axes axes{};
  std::copy(q.begin(), q.end(), axes.begin());
  return axes;
}

JointVector to_joints(const eki::Axes& axes) {
  JointVector q(static_cast<Eigen::Index>(axes.size()));
  std::copy(axes.begin(), axes.end(), q.begin());
  return q;
}

SimTime KukaController::Moving::end() const { return since + to_sim_time(motion.duration()); }

KukaController::KukaController(ControllerSetup setup) : setup_{std::move(setup)}, q_{setup_.start} {
  if (setup_.nominal.joint_count() != 6) {
    throw std::invalid_argument("the simulated controller moves an arm of six axes, and '" +
                                setup_.nominal.name + "' has " +
                                std::to_string(setup_.nominal.joint_count()));
  }
}

eki::Hello KukaController::hello() const {
  return {.model = setup_.model, .serial = setup_.serial, .kss_version = "KSS 8.6.11 (simulated)"};
}

std::vector<eki::Ack> KukaController::command(const eki::Command& command, SimTime now) {
  said_ = advance(now);
  const bool seen = last_ack_ && last_ack_->id == command.id;
  const bool awaits = std::ranges::count(waiting_, command.id, &eki::Command::id) > 0;
  if (seen) {
    said_.push_back(*last_ack_);
  } else if (!awaits && waiting_.size() < kBufferedCommands) {
    waiting_.push_back(command);
  }
  std::vector<eki::Ack> said = take_said();
  std::ranges::move(advance(now), std::back_inserter(said));
  return said;
}

KukaController::ControlAnswer KukaController::control(const eki::Control& control, SimTime now) {
  said_ = advance(now);
  switch (control.op) {
    case eki::ControlOp::SetOverride:
      override_percent_ = std::clamp(control.value, 1, kMaxOverridePercent);
      break;
    case eki::ControlOp::Stop:
      stopped_ = true;
      brake(eki::AckError::Stopped, now);
      break;
    case eki::ControlOp::ReleaseStop:
      stopped_ = false;
      break;
    case eki::ControlOp::Drives:
      drives_on_ = control.value != 0;
      if (!drives_on_) brake(eki::AckError::Stopped, now);
      break;
    case eki::ControlOp::AskState:
      break;
  }
  return {.state = report(control.id, now), .acks = take_said()};
}

void KukaController::link_lost(SimTime now) {
  advance(now);  // its words reach nobody any more; the last one is repeated when asked for
  waiting_.clear();
  brake(eki::AckError::LinkLost, now);
  take_said();
}

std::vector<eki::Ack> KukaController::advance(SimTime now) {
  for (std::optional<SimTime> change = next_change(); change && *change <= now; change = next_change()) {
    if (const auto* moving = std::get_if<Moving>(&doing_)) {
      const eki::Command command = moving->command;
      stand(*change);
      if (command.type == eki::CommandType::StartRsi) {
        doing_ = Streaming{.command = command};
        say(command.id, eki::AckState::Moving);
      } else {
        doing_ =
            Settling{.command = command, .until = *change + std::chrono::milliseconds{command.settle_ms}};
      }
    } else if (const auto* settling = std::get_if<Settling>(&doing_)) {
      say(settling->command.id, eki::AckState::InPosition);
      doing_ = Standing{};
    } else {
      const eki::Command command = waiting_.front();
      waiting_.pop_front();
      begin(command, now);
    }
  }
  return take_said();
}

std::optional<SimTime> KukaController::next_change() const {
  if (const auto* moving = std::get_if<Moving>(&doing_)) return moving->end();
  if (const auto* settling = std::get_if<Settling>(&doing_)) return settling->until;
  if (std::holds_alternative<Standing>(doing_) && !waiting_.empty()) return SimTime::min();  // at once
  return std::nullopt;
}

void KukaController::begin(const eki::Command& command, SimTime now) {
  if (const std::optional<eki::AckError> error = refusal(command)) {
    say(command.id, eki::AckState::Rejected, static_cast<int>(*error));
    return;
  }
  if (command.type == eki::CommandType::NoOp) return say(command.id, eki::AckState::InPosition);
  say(command.id, eki::AckState::Accepted);

  const bool rsi = command.type == eki::CommandType::StartRsi;
  const double scale = speed_scale(command);
  const Seconds ramp = kFullSpeedAfter * scale * 100.0 / std::clamp(command.acceleration_percent, 1, 100);
  doing_ = Moving{
      .command = command,
      .motion = {setup_.nominal, q_, rsi ? setup_.rsi_start : to_joints(command.axes_rad), scale, ramp},
      .since = now};
  ++moves_;
  if (!rsi) say(command.id, eki::AckState::Moving);
}

std::optional<eki::AckError> KukaController::refusal(const eki::Command& command) const {
  if (stopped_ || !drives_on_) return eki::AckError::Stopped;
  switch (command.type) {
    case eki::CommandType::NoOp:
    case eki::CommandType::StartRsi:
      return std::nullopt;
    case eki::CommandType::Ptp:
      for (std::size_t i = 0; i < command.axes_rad.size(); ++i) {
        const Joint& joint = setup_.nominal.joints[i];
        // Written so that a NaN is out of range too.
        if (!(command.axes_rad[i] >= joint.min && command.axes_rad[i] <= joint.max))
          return eki::AckError::OutOfRange;
      }
      return std::nullopt;
  }
  return eki::AckError::UnknownType;
}

/// Stands still where it is; the way that braking takes is not simulated.
void KukaController::brake(eki::AckError error, SimTime now) {
  const auto abort = [&](const eki::Command& command) {
    stand(now);
    doing_ = Standing{};
    say(command.id, eki::AckState::Aborted, static_cast<int>(error));
  };
  if (const auto* moving = std::get_if<Moving>(&doing_)) {
    abort(eki::Command{moving->command});
  } else if (const auto* settling = std::get_if<Settling>(&doing_)) {
    abort(eki::Command{settling->command});
  } else if (const auto* streaming = std::get_if<Streaming>(&doing_)) {
    abort(eki::Command{streaming->command});
  }
}

void KukaController::stand(SimTime now) {
  q_ = axes(now);
  ++stops_;
}

void KukaController::say(std::int32_t id, eki::AckState state, int error) {
  last_ack_ = eki::Ack{.id = id, .state = state, .error = error, .axes_rad = to_axes(q_)};
  said_.push_back(*last_ack_);
}

std::vector<eki::Ack> KukaController::take_said() { return std::exchange(said_, {}); }

double KukaController::speed_scale(const eki::Command& command) const {
  return std::clamp(command.velocity_percent, 1, 100) / 100.0 * override_percent_ / 100.0;
}

JointVector KukaController::axes(SimTime now) const {
  const auto* moving = std::get_if<Moving>(&doing_);
  return moving ? moving->motion.position(now - moving->since) : q_;
}

bool KukaController::moving(SimTime now) const {
  if (const auto* moving = std::get_if<Moving>(&doing_)) return now < moving->end();
  const auto* streaming = std::get_if<Streaming>(&doing_);
  return streaming && streaming->moving;
}

std::optional<double> KukaController::rsi_speed() const {
  const auto* streaming = std::get_if<Streaming>(&doing_);
  return streaming ? std::optional{speed_scale(streaming->command)} : std::nullopt;
}

void KukaController::rsi_cycle(const JointVector& q, bool moving) {
  if (auto* streaming = std::get_if<Streaming>(&doing_)) {
    streaming->moving = moving;
    q_ = q;
  }
}

std::vector<eki::Ack> KukaController::rsi_ended(RsiEnd end, SimTime now) {
  if (const auto* streaming = std::get_if<Streaming>(&doing_)) {
    const std::int32_t id = streaming->command.id;
    stand(now);
    doing_ = Standing{};
    end == RsiEnd::Left ? say(id, eki::AckState::InPosition) : say(id, eki::AckState::Aborted, kKss29002);
  }
  return take_said();
}

eki::State KukaController::report(std::int32_t id, SimTime now) {
  const JointVector q = axes(now);
  const Eigen::Isometry3d X_BF = forward_kinematics(setup_.nominal, q);
  const Eigen::Vector3d p = X_BF.translation();
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X_BF.linear());
  return {.sequence = ++states_sent_,
          .id = id,
          .mode = eki::OperatingMode::Ext,
          .override_percent = override_percent_,
          .program = stopped_ ? eki::ProgramState::Stopped : eki::ProgramState::Active,
          .drives_ready = drives_on_,
          .no_emergency_stop = true,
          .gate_closed = true,
          .stop_message = stopped_,
          .moving = moving(now),
          .in_position = !moving(now),
          .axes_rad = to_axes(q),
          .pose = {p.x(), p.y(), p.z(), abc_deg[0], abc_deg[1], abc_deg[2]}};
}

}  // namespace truepose::sim
