#include "daemon/realtime/stream_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace truepose::daemon {
namespace {

constexpr int kAxes = 6;

// Malformed packets that come after such a pause may be malformed for another reason than those before it.
constexpr std::chrono::seconds kNewRow{1};

/// For the solver: the limits are bound_correction()'s to keep, which holds one axis at its limit where the
/// solver would refuse the target.
RobotModel without_limits(RobotModel robot) {
  for (Joint& joint : robot.joints) {
    joint.min = -std::numeric_limits<double>::infinity();
    joint.max = std::numeric_limits<double>::infinity();
  }
  return robot;
}

SessionOptions session_options(const StreamOptions& options) {
  return {.cycle = options.cycle,
          .gap_cycles = options.timeout_cycles,
          .step_rad = options.max_step_rad,
          .peer = options.peer,
          .listening_since = options.listening_since,
          .never_corrected = options.never_corrected};
}

}  // namespace

std::expected<std::unique_ptr<StreamCycle>, std::string> StreamCycle::create(
    const RobotModel& nominal, const rsi::EthernetConfig& ethernet, const StreamOptions& options,
    StreamMemory* memory) {
  if (auto why = why_unfit(nominal, ethernet, options)) return std::unexpected(std::move(*why));
  return std::unique_ptr<StreamCycle>(new StreamCycle(nominal, ethernet, options, memory));
}

StreamCycle::StreamCycle(const RobotModel& nominal, const rsi::EthernetConfig& ethernet,
                         const StreamOptions& options, StreamMemory* memory)
    : nominal_{nominal},
      options_{options},
      bounds_{options.bounds(nominal)},
      codec_{ethernet},
      has_stop_{ethernet.stop.has_value()},
      sends_aspos_{ethernet.sends("ASPos")},
      done_{options.listening_since},
      session_{session_options(options), memory},
      missing_{ethernet, options.cycles_per_second()},
      late_replies_{options.rejected_cycles},
      lateness_{options.cycle},
      following_{static_cast<double>(options.cycle.count()), options.following_tolerance_rad},
      arm_check_{nominal, options.cycle, options.max_fk_deviation_mm},
      ramp_{options.ramp_cycles, kAxes},
      correction_{session_.last_sent()},
      arm_known_{session_.known() && !correction_.isZero(0)} {
  if (!correction_.isZero(0)) ramp_.start_from_current();
}

void StreamCycle::use_model(const RobotModel& calibrated, std::uint64_t number,
                            const Eigen::Vector3d& p_F_mm) {
  // The realtime thread's own directions, as they are when it asks.
  const CompensationOptions damping{.singular_below = options_.singular_below_rad,
                                    .approach = approach_.directions()};
  model_.use(number, TargetCompensation{without_limits(nominal_), calibrated, damping}, p_F_mm);
}

StreamStatus StreamCycle::status() const {
  const std::lock_guard lock{status_mutex_};
  published_.take();
  return published_.front();
}

std::string_view StreamCycle::answer(const drivers::Datagram& datagram) noexcept {
  admitted_ = session_.admits(datagram.source, datagram.received);
  if (!admitted_) {
    report_foreign(datagram.source);
    return {};
  }
  ++status_.counters.datagrams;
  status_.read_until = datagram.received;
  take_commands();
  return answer_controller(datagram);
}

void StreamCycle::finish(const drivers::CycleTimes& times) noexcept {
  if (admitted_) {
    received_ = times.received;
    done_ = times.sent;
    late_replies_.dealt_with(times);
    if (times.replied) count(times);
    watch_effect();
    update_state();
    model_.look_ahead();
  }
  publish();
}

void StreamCycle::count(const drivers::CycleTimes& times) noexcept {
  turnaround_.record(times.sent - times.received);
  compute_.record(times.ready - times.taken);
  const auto late_by = lateness_.judge(times);
  status_.counters.late_by_daemon += late_by == LateBy::Daemon;
  status_.counters.late_by_machine += late_by == LateBy::Machine;
  status_.counters.late_by_network += late_by == LateBy::Network;
}

void StreamCycle::on_no_datagram(drivers::TimePoint until) noexcept {
  status_.read_until = until;
  if (take_acknowledgement()) update_state();
  publish();
}

/// Counted, and named once for each address.
void StreamCycle::report_foreign(const drivers::UdpSource& source) noexcept {
  ++status_.counters.unexpected_sender;
  const auto known = foreign_.begin() + static_cast<std::ptrdiff_t>(foreign_count_);
  if (foreign_count_ == foreign_.size() || std::find(foreign_.begin(), known, source.address) != known)
    return;
  foreign_[foreign_count_++] = source.address;
  emit({.kind = StreamEventKind::Foreign, .source = source});
}

void StreamCycle::take_commands() noexcept {
  engagement_seen_ = engagement_.load(std::memory_order_acquire);
  if (model_.take_model()) {
    ++models_taken_;
    status_.model = model_.model();
    ramp_.start_from_current();
    emit({.kind = StreamEventKind::ModelChanged, .value = status_.model});
  }
  take_acknowledgement();
}

bool StreamCycle::take_acknowledgement() noexcept {
  const std::uint32_t acknowledged = acknowledged_.load(std::memory_order_acquire);
  if (std::exchange(acknowledged_seen_, acknowledged) == acknowledged) return false;
  status_.acknowledged = acknowledged;
  acknowledge_fault();
  return true;
}

void StreamCycle::acknowledge_fault() noexcept {
  status_.fault = StreamFault::None;
  status_.detail = {};
  broken_ = unsolved_ = 0;
  missing_.restart();
  late_replies_.restart();
  following_.forget();
  arm_check_.restart();
}

std::string_view StreamCycle::answer_controller(const drivers::Datagram& datagram) noexcept {
  const auto frame = decoder_.decode(datagram.bytes);
  if (!frame) return answer_malformed(frame.error(), datagram);
  const bool commanded = sends_aspos_ ? frame->aspos_rad.has_value() : frame->aipos_rad.has_value();
  if (!commanded) {
    return answer_malformed({.fault = rsi::FrameFault::Missing, .element = sends_aspos_ ? "ASPos" : "AIPos"},
                            datagram);
  }
  if (frame->unread) report_unread(*frame->unread, datagram);
  return answer_frame(*frame, datagram);
}

/// Counted, and reported once in a session.
void StreamCycle::report_unread(const rsi::FrameError& error, const drivers::Datagram& datagram) noexcept {
  ++status_.counters.partly_read;
  if (std::exchange(unread_reported_, true)) return;
  emit({.kind = StreamEventKind::PartlyRead,
        .source = datagram.source,
        .excerpt = Excerpt::of(datagram.bytes, error.offset),
        .error = error});
}

std::string_view StreamCycle::answer_frame(const rsi::RobotFrame& frame,
                                           const drivers::Datagram& datagram) noexcept {
  malformed_before_ = false;
  disarm_after_silence(datagram.received);
  const FrameVerdict verdict = session_.judge(frame, datagram.source, datagram.received);
  status_.peer_waits = session_.peer_waits();
  if (verdict.began) begin_session(datagram.source);
  lateness_.heard(datagram.received, verdict.elapsed);
  if (verdict.lost > 0) {
    status_.counters.lost += verdict.lost;
    emit({.kind = StreamEventKind::PacketsLost, .value = verdict.lost});
  }
  // Before anything of what is in effect is known: how long that takes to see depends on it.
  auto wrong_cycle = arm_check_.cycle(session_.step());
  if (wrong_cycle && session_.port_before() != 0)
    wrong_cycle->detail.ports = {session_.port_before(), datagram.source.port};
  raise(wrong_cycle);
  switch (verdict.turn) {
    case Turn::Repeat:
      return repeat(frame.ipoc);
    case Turn::WrongIpoc:
      ++status_.counters.wrong_ipoc;
      return {};
    case Turn::Unproven:
      ++status_.counters.unconfirmed;
      last_commanded_.reset();
      following_.restart();
      return {};
    case Turn::Offer:
      correction_.setZero();
      ramp_.reset();
      return hold();
    case Turn::Answer:
      return answer_cycle(frame, verdict, datagram.received);
  }
  return {};
}

std::string_view StreamCycle::answer_cycle(const rsi::RobotFrame& frame, const FrameVerdict& verdict,
                                           drivers::TimePoint received) noexcept {
  listen_to_program(frame.program);
  if (verdict.settled) adopt(*commanded_axes(frame));
  const JointVector commanded = *commanded_axes(frame);
  if (!plausible(commanded, verdict)) return hold();

  watch(frame, verdict, received);
  // Where the commanded axes are guessed from the actual ones our own correction would turn them round.
  if (sends_aspos_ && approach_.take(commanded)) model_.turned_round();
  last_commanded_ = commanded;
  for (Eigen::Index i = 0; i < kAxes; ++i) {
    status_.commanded_deg[static_cast<std::size_t>(i)] = commanded[i] * kDegPerRad;
  }

  const bool free = status_.fault == StreamFault::None && !status_.program_stopped;
  if (!free) ramp_.start_from_current();
  const std::uint64_t cycles =
      verdict.settled ? 1 : verdict.elapsed;  // what was not answered is no part of a ramp
  if (!free || verdict.missed || !correct(commanded, static_cast<double>(cycles))) return hold();
  ++status_.counters.answered;
  return reply();
}

void StreamCycle::listen_to_program(const rsi::ProgramSignals& program) noexcept {
  program_.listen(program, engagement());
  status_.program = program.state;
  status_.mode = program.mode;
  status_.override_percent = program.override_percent;
  status_.cell = program.cell;
  status_.program_stopped = program_.stopped();
  status_.program_declines = program_.declines();
}

std::string_view StreamCycle::answer_malformed(const rsi::FrameError& error,
                                               const drivers::Datagram& datagram) noexcept {
  ++status_.counters.malformed;
  const bool after_pause = received_ && datagram.received - *received_ >= kNewRow;
  if (!std::exchange(malformed_before_, true) || after_pause) {
    emit({.kind = StreamEventKind::Malformed,
          .source = datagram.source,
          .excerpt = Excerpt::of(datagram.bytes, error.offset),
          .error = error});
  }
  const auto ipoc = rsi::readable_ipoc(datagram.bytes);
  if (!ipoc || !session_.judge_malformed(*ipoc, datagram.source, datagram.received)) {
    ++status_.counters.unanswered;
    return {};
  }
  following_.restart();
  return replied_ipoc_ == ipoc ? repeat(*ipoc) : hold();
}

/// The last correction once more: within a step of all that may be in effect, as it was when it was sent.
std::string_view StreamCycle::hold() noexcept {
  ++status_.counters.held;
  return reply();
}

std::string_view StreamCycle::repeat(std::uint64_t ipoc) noexcept {
  // Of a process before this one the controller may repeat what that one answered.
  if (replied_ipoc_ != ipoc) {
    ++status_.counters.wrong_ipoc;
    return {};
  }
  ++status_.counters.duplicate;
  return {buffer_.data(), reply_bytes_};
}

std::string_view StreamCycle::reply() noexcept {
  rsi::SensorFrame frame{.ipoc = session_.ipoc(), .axis_correction_rad = rsi::Axes{}, .stop = std::nullopt};
  std::copy(correction_.begin(), correction_.end(), frame.axis_correction_rad->begin());
  if (has_stop_) frame.stop = asks_to_leave();
  frame.gain = gain_for_program(seen_by_program());
  const auto bytes = codec_.encode(frame, buffer_);
  if (!bytes) return {};
  replied_ipoc_ = frame.ipoc;
  reply_bytes_ = bytes->size();
  session_.reply(correction_);
  return *bytes;
}

/// Out of RSI_MOVECORR, where a program of its own is, the Stop object would be an error. A lost reply ends
/// the pulse (HOLDON="0"), the next begins another.
bool StreamCycle::asks_to_leave() const noexcept {
  const bool faulted = status_.fault == StreamFault::BoundBroken ||
                       status_.fault == StreamFault::NoSolution || status_.fault == StreamFault::JointLimit;
  return !program_.production() && (faulted || (engagement() == Engagement::Leaving && at_rest()));
}

StreamForProgram StreamCycle::seen_by_program() const noexcept {
  return {.faulted = status_.fault != StreamFault::None,
          .wanted = wanted(),
          .modelled = status_.model != 0,
          .complete = ramp_.whole() && !behind_,
          .zero = correction_.isZero(0),
          .gain = ramp_.gain()};
}

void StreamCycle::begin_session(const drivers::UdpSource& source) noexcept {
  ++status_.counters.sessions;
  Engagement left = Engagement::Leaving;  // what was asked to end has ended
  engagement_.compare_exchange_strong(left, Engagement::Off);
  broken_ = unsolved_ = 0;
  implausible_ = 0;
  missing_.restart();
  late_replies_.restart();
  lateness_.restart();
  arm_check_.restart();
  malformed_before_ = unread_reported_ = false;
  replied_ipoc_.reset();
  last_commanded_.reset();
  approach_.restart();
  model_.restart();
  following_.restart();
  emit({.kind = StreamEventKind::SessionStarted, .value = session_.ipoc(), .source = source});
}

/// Goes on from what has just become known to be in effect.
void StreamCycle::adopt(const JointVector& commanded) noexcept {
  // No operator confirms each program of an armed stream: the correction that one left behind is known now.
  if (engagement() == Engagement::Armed && status_.fault == StreamFault::NotFollowing) acknowledge_fault();
  const CorrectionRange& in_effect = session_.in_effect();
  const auto contains = [&](const JointVector& correction) {
    return (correction - in_effect.min).minCoeff() >= 0 && (in_effect.max - correction).minCoeff() >= 0;
  };
  const JointVector zero = JointVector::Zero(kAxes);
  const JointVector likely = contains(correction_) ? correction_
                             : contains(zero)      ? zero
                                                   : JointVector{(in_effect.min + in_effect.max) / 2};
  const JointVector before =
      std::exchange(correction_, bound_correction(likely, in_effect, commanded, bounds_).correction);
  if (before != correction_) following_.restart();
  arm_known_ = !correction_.isZero(0);  // an operator has looked
  arm_check_.restart();
  if (correction_.isZero(0)) {
    ramp_.reset();
  } else {
    ramp_.start_from_current();
  }
  emit({.kind = StreamEventKind::SessionProven,
        .value =
            static_cast<std::uint64_t>(std::lround(correction_.cwiseAbs().maxCoeff() * kDegPerRad * 1e6))});
}

/// A correction that resumes by itself with the controller may endanger a person in the cell.
void StreamCycle::disarm_after_silence(drivers::TimePoint received) noexcept {
  const auto silence = status_.heard ? received - *status_.heard : drivers::Duration{0};
  status_.heard = received;
  const bool disarms = engagement_before_ == Engagement::On && options_.disarm_after;
  if (disarms && silence >= *options_.disarm_after) {
    disengage();
    engagement_seen_ = Engagement::Off;
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(silence);
    emit({.kind = StreamEventKind::Disarmed, .value = static_cast<std::uint64_t>(ms.count())});
  }
  engagement_before_ = engagement();
}

/// Moves the correction on by one reply. @return false where it was held instead
bool StreamCycle::correct(const JointVector& commanded, double cycles) noexcept {
  const bool engaged = this->engaged(), asks_model = ramp_.asks_model(engaged, cycles);
  if (asks_model && !model_.solve(commanded)) {
    ++status_.counters.no_solution;
    if (engaged) {
      ramp_.start_from_current();
      unsolved_ += cycles;
      if (unsolved_ >= options_.broken_cycles) raise(unsolved());
      return false;
    }
    // On the way out the model's last wish serves: the correction must come to zero in any case.
  }
  unsolved_ = 0;
  status_.counters.damped += asks_model && model_.damped();
  const JointVector wanted = ramp_.advance(engaged, cycles, model_.value(), correction_);
  status_.gain = ramp_.gain();

  const BoundedCorrection bounded = bound_correction(wanted, session_.in_effect(), commanded, bounds_);
  count(bounded.clamps);
  behind_ = bounded.clamps.step || bounded.clamps.total;
  const double change_deg = (bounded.correction - correction_).cwiseAbs().maxCoeff() * kDegPerRad;
  status_.max_step_deg = std::max(status_.max_step_deg, change_deg);
  correction_ = bounded.correction;

  broken_ = engaged && bounded.clamps.broken() ? broken_ + cycles : 0;
  if (broken_ >= options_.broken_cycles) raise(broken_bound(commanded, wanted, bounded));
  return !bounded.clamps.not_finite;
}

FoundFault StreamCycle::unsolved() const noexcept {
  const auto& why = model_.no_solution();
  const bool at_limit = why && why->kind == CompensationFault::Kind::BeyondLimit;
  return at_limit ? joint_limit(why->joint, why->q_wrong) : FoundFault{StreamFault::NoSolution, {}};
}

/// @param q_rad  where the axis is with its correction
FoundFault StreamCycle::joint_limit(Eigen::Index axis, double q_rad) const noexcept {
  const double lower = bounds_.min[axis] + bounds_.limit_margin;
  const double upper = bounds_.max[axis] - bounds_.limit_margin;
  return {StreamFault::JointLimit,
          {.axis = static_cast<int>(axis) + 1,
           .value = q_rad * kDegPerRad,
           .limit = (q_rad < lower ? lower : upper) * kDegPerRad}};
}

/// The axis that its limit holds back most, else the one that gets least of what the model asks for.
FoundFault StreamCycle::broken_bound(const JointVector& commanded, const JointVector& wanted,
                                     const BoundedCorrection& bounded) const noexcept {
  if (bounded.clamps.limit && !bounded.clamps.total) {
    const JointVector q = commanded + wanted;
    const auto beyond = [&](Eigen::Index i) {
      return std::max(bounds_.min[i] - q[i], q[i] - bounds_.max[i]);
    };
    Eigen::Index farthest = 0;
    for (Eigen::Index i = 1; i < kAxes; ++i)
      if (beyond(i) > beyond(farthest)) farthest = i;
    return joint_limit(farthest, q[farthest]);
  }
  Eigen::Index axis = 0;
  (wanted - bounded.correction).cwiseAbs().maxCoeff(&axis);
  const double limit = bounded.clamps.total ? bounds_.max_total : std::abs(bounded.correction[axis]);
  return {
      StreamFault::BoundBroken,
      {.axis = static_cast<int>(axis) + 1, .value = wanted[axis] * kDegPerRad, .limit = limit * kDegPerRad}};
}

void StreamCycle::count(const CorrectionClamps& clamps) noexcept {
  StreamCounters& counters = status_.counters;
  counters.clamped_step += clamps.step;
  counters.clamped_total += clamps.total;
  counters.clamped_limit += clamps.limit;
  counters.clamped_not_finite += clamps.not_finite;
}

/// The first fault stays until it is acknowledged.
void StreamCycle::raise(const std::optional<FoundFault>& found) noexcept {
  if (!found || status_.fault != StreamFault::None) return;
  status_.fault = found->fault;
  status_.detail = found->detail;
}

void StreamCycle::update_state() noexcept {
  StreamState state = StreamState::Idle;
  if (status_.fault == StreamFault::NotFollowing) {
    state = StreamState::Frozen;
  } else if (status_.fault != StreamFault::None) {
    state = StreamState::Fault;
  } else if (session_.begun() && !session_.known()) {
    state = StreamState::Unproven;
  } else if (session_.begun() && engaged()) {
    state = ramp_.full() ? StreamState::Active : StreamState::RampingIn;
  } else if (!at_rest()) {
    state = StreamState::RampingOut;
  }
  if (std::exchange(status_.state, state) != state) emit({.kind = StreamEventKind::StateChanged});
}

void StreamCycle::emit(StreamEvent event) noexcept {
  event.state = status_.state;
  event.fault = status_.fault;
  event.detail = status_.detail;
  event.ipoc = session_.ipoc();
  events_.push(event);
}

void StreamCycle::publish() noexcept {
  for (Eigen::Index i = 0; i < kAxes; ++i) {
    status_.correction_deg[static_cast<std::size_t>(i)] = correction_[i] * kDegPerRad;
  }
  status_.measured_deg = following_.measured_deg();
  status_.peer = session_.peer();
  status_.ipoc = session_.ipoc();
  status_.ipoc_step = session_.step();
  published_.back() = status_;
  published_.publish();
}

}  // namespace truepose::daemon
