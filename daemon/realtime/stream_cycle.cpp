#include "daemon/realtime/stream_cycle.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace truepose::daemon {
namespace {

constexpr int kAxes = 6;

// No axis moves so far in a cycle of 12 ms: 220 deg/s are 2.6 deg.
constexpr double kGreatestMotionRad = 3 * kRadPerDeg;
// Leaving RSI and starting it anew takes the controller's interpreter longer than this.
constexpr std::uint64_t kShortestRestartCycles = 10;
// So many implausible frames in a row are believed after all.
constexpr int kImplausibleFrames = 10;
// A correction that is large enough to be looked for in the actual axes.
constexpr double kVisibleCorrectionRad = 0.02 * kRadPerDeg;
// A reply sent so soon was in time, and datagrams so close together come out of a backlog.
constexpr std::chrono::milliseconds kInTime{1};

JointVector vector_of(const rsi::Axes& axes) {
  return Eigen::Map<const Eigen::Matrix<double, kAxes, 1>>(axes.data());
}

/// Start and end without a kink, so that a ramp does not jerk the arm.
double smooth(double x) { return x * x * (3 - 2 * x); }

/// The number between the only <IPOC> and </IPOC> of a datagram that is otherwise not understood.
std::optional<std::uint64_t> readable_ipoc(std::string_view datagram) noexcept {
  constexpr std::string_view kOpen = "<IPOC>", kClose = "</IPOC>";
  const std::size_t open = datagram.find(kOpen);
  if (open == std::string_view::npos || datagram.rfind(kOpen) != open) return std::nullopt;
  const char* const first = datagram.data() + open + kOpen.size();
  const char* const end = datagram.data() + datagram.size();
  std::uint64_t ipoc = 0;
  const auto [rest, error] = std::from_chars(first, end, ipoc);
  if (error != std::errc{} || !std::string_view(rest, end).starts_with(kClose)) return std::nullopt;
  return ipoc;
}

CorrectionBounds bounds_of(const RobotModel& robot, const StreamOptions& options) {
  CorrectionBounds bounds{.max_step = options.max_step_rad,
                          .max_total = options.max_total_rad,
                          .min = JointVector(robot.joint_count()),
                          .max = JointVector(robot.joint_count()),
                          .limit_margin = options.limit_margin_rad};
  for (Eigen::Index i = 0; i < robot.joint_count(); ++i) {
    bounds.min[i] = robot.joints[static_cast<std::size_t>(i)].min;
    bounds.max[i] = robot.joints[static_cast<std::size_t>(i)].max;
  }
  return bounds;
}

/// For the solver: the limits are bound_correction()'s to keep, which holds one axis at its limit where the
/// solver would refuse the target.
RobotModel without_limits(RobotModel robot) {
  for (Joint& joint : robot.joints) {
    joint.min = -std::numeric_limits<double>::infinity();
    joint.max = std::numeric_limits<double>::infinity();
  }
  return robot;
}

bool asks_to_stop(StreamFault fault) {
  return fault == StreamFault::BoundBroken || fault == StreamFault::NoSolution;
}

}  // namespace

StreamOptions StreamOptions::of(const config::StreamConfig& config) {
  const auto cycles = [&](std::chrono::milliseconds time) {
    return std::max(1, static_cast<int>(time / config.cycle));
  };
  using namespace std::chrono_literals;
  return {.max_step_rad = config.max_step_deg * kRadPerDeg,
          .max_total_rad = config.max_total_deg * kRadPerDeg,
          .limit_margin_rad = config.limit_margin_deg * kRadPerDeg,
          .singular_below_rad = config.singular_deg * kRadPerDeg,
          .ramp_cycles = cycles(config.ramp),
          .broken_cycles = cycles(1s),
          .following_cycles = cycles(1s),
          .following_lag_cycles = cycles(160ms)};
}

std::expected<std::unique_ptr<StreamCycle>, std::string> StreamCycle::create(
    const RobotModel& nominal, const rsi::EthernetConfig& ethernet, const StreamOptions& options) {
  const auto revolute = [](const Joint& joint) { return joint.type == JointType::Revolute; };
  if (nominal.joint_count() != kAxes ||
      !std::all_of(nominal.joints.begin(), nominal.joints.end(), revolute)) {
    return std::unexpected("the stream corrects six revolute axes, but " + nominal.name +
                           " has other joints");
  }
  if (ethernet.only_send) {
    return std::unexpected("the RSI configuration has ONLYSEND=TRUE: the controller takes no correction");
  }
  if (!ethernet.axis_correction) {
    return std::unexpected("the RSI configuration receives no axis correction (an element with A1 to A6)");
  }
  if (!ethernet.sends("ASPos") && !ethernet.sends("AIPos")) {
    return std::unexpected(
        "the RSI configuration sends neither DEF_ASPos nor DEF_AIPos: the commanded axes are unknown");
  }
  const double greatest = 90 * kRadPerDeg;
  const double grid = CorrectionBounds{}.resolution;
  if (!(options.max_step_rad >= grid && options.max_step_rad <= greatest) ||
      !(options.max_total_rad >= grid && options.max_total_rad <= greatest) || options.ramp_cycles < 1) {
    return std::unexpected(
        "step, total and ramp of the correction must be positive, and the first two at most 90 deg");
  }
  return std::unique_ptr<StreamCycle>(new StreamCycle(nominal, ethernet, options));
}

StreamCycle::StreamCycle(const RobotModel& nominal, const rsi::EthernetConfig& ethernet,
                         const StreamOptions& options)
    : nominal_{nominal},
      options_{options},
      bounds_{bounds_of(nominal, options)},
      codec_{ethernet},
      has_stop_{ethernet.stop.has_value()},
      sends_aspos_{ethernet.sends("ASPos")},
      sequence_{options.timeout_cycles},
      correction_{JointVector::Zero(kAxes)},
      model_correction_{JointVector::Zero(kAxes)},
      fade_{JointVector::Zero(kAxes)} {}

void StreamCycle::use_model(const RobotModel& calibrated, std::uint64_t number,
                            const Eigen::Vector3d& p_F_mm) {
  const CompensationOptions damping{.singular_below = options_.singular_below_rad, .approach = {}};
  model_.back() = Model{.number = number,
                        .compensation = TargetCompensation{without_limits(nominal_), calibrated, damping},
                        .p_F_mm = p_F_mm};
  model_.publish();
}

void StreamCycle::use_no_model() {
  model_.back() = Model{};
  model_.publish();
}

StreamStatus StreamCycle::status() const {
  const std::lock_guard lock{status_mutex_};
  published_.take();
  return published_.front();
}

std::string_view StreamCycle::answer(std::string_view datagram, drivers::TimePoint received) noexcept {
  ++status_.counters.datagrams;
  take_commands();
  const auto frame = rsi::decode_robot_frame(datagram);
  const std::string_view bytes =
      frame ? answer_frame(*frame, received) : answer_malformed(readable_ipoc(datagram));
  update_state();
  publish();
  received_ = received;
  last_turnaround_ = options_.now() - received;
  turnaround_.record(last_turnaround_);
  return bytes;
}

void StreamCycle::take_commands() noexcept {
  if (model_.take()) {
    status_.model = model_.front().number;
    refade_ = true;
    emit(StreamEventKind::ModelChanged, status_.model);
  }
  const std::uint32_t acknowledged = acknowledged_.load(std::memory_order_acquire);
  if (acknowledged != acknowledged_seen_) {
    acknowledged_seen_ = acknowledged;
    status_.fault = StreamFault::None;
    broken_ = unsolved_ = not_following_ = 0;
    rejected_ = 0;
  }
}

std::string_view StreamCycle::answer_frame(const rsi::RobotFrame& frame,
                                           drivers::TimePoint received) noexcept {
  std::optional<JointVector> commanded = commanded_axes(frame);
  if (!commanded) return answer_malformed(frame.ipoc);
  malformed_before_ = false;

  Position position = sequence_.place(frame.ipoc);
  if (position.place == Place::Duplicate || position.place == Place::Stale) {
    return hold(frame.ipoc, position);
  }
  if (position.place == Place::NewSession && !sequence_.confirms_session(frame.ipoc))
    return hold(frame.ipoc, position);
  if (position.place == Place::NewSession || restarted(frame, position)) {
    start_session(frame.ipoc);
    position = Position{.forward = 0, .elapsed = 0};
    commanded = commanded_axes(frame);
  } else {
    if (!plausible(*commanded, position)) return hold(frame.ipoc, position);
    advance(frame.ipoc, position);
  }

  const bool arriving = replies_arrive(frame, position, received);
  watch_following(frame, *commanded, position);
  last_commanded_ = *commanded;
  for (Eigen::Index i = 0; i < kAxes; ++i) {
    status_.commanded_deg[static_cast<std::size_t>(i)] = (*commanded)[i] * kDegPerRad;
  }

  if (status_.fault != StreamFault::None) {
    refade_ = true;
    ++status_.counters.held;
  } else if (arriving && position.elapsed < kShortestRestartCycles &&
             correct(*commanded, static_cast<double>(position.elapsed))) {
    ++status_.counters.answered;
  } else {
    ++status_.counters.held;
  }
  return reply(frame.ipoc, correction_);
}

std::string_view StreamCycle::answer_malformed(std::optional<std::uint64_t> ipoc) noexcept {
  ++status_.counters.malformed;
  if (!std::exchange(malformed_before_, true)) emit(StreamEventKind::Malformed);
  if (!ipoc) {
    ++status_.counters.unanswered;
    return {};
  }
  return hold(*ipoc, sequence_.place(*ipoc));
}

std::string_view StreamCycle::hold(std::uint64_t ipoc, const Position& position) noexcept {
  switch (position.place) {
    case Place::Duplicate:
      ++status_.counters.duplicate;
      break;
    case Place::Stale:
      ++status_.counters.stale;
      break;
    case Place::Next:
      if (position.elapsed >= kShortestRestartCycles) {
        // The controller may have begun anew at zero, and this frame cannot tell: without a reply it keeps
        // what it has.
        ++status_.counters.unanswered;
        return {};
      }
      ++status_.counters.held;
      advance(ipoc, position);
      break;
    case Place::NewSession:
      // A new start begins at zero. Should only the IPOC be garbage, then the controller discards this reply,
      // and the session that it knows goes on.
      ++status_.counters.held;
      return reply(ipoc, JointVector::Zero(kAxes));
  }
  return reply(ipoc, correction_);
}

std::string_view StreamCycle::reply(std::uint64_t ipoc, const JointVector& correction) noexcept {
  rsi::SensorFrame frame{.ipoc = ipoc, .axis_correction_rad = rsi::Axes{}, .stop = std::nullopt};
  std::copy(correction.begin(), correction.end(), frame.axis_correction_rad->begin());
  if (has_stop_) frame.stop = asks_to_stop(status_.fault);
  const auto bytes = codec_.encode(frame, buffer_);
  return bytes ? *bytes : std::string_view{};
}

// After a silence too short for the controller to give up, only itself can tell that it began anew: nothing
// is left in the actual axes of a correction that they had followed, or, where they cannot be compared, it
// counts late replies from zero.
bool StreamCycle::restarted(const rsi::RobotFrame& frame, const Position& position) const noexcept {
  if (position.elapsed < kShortestRestartCycles) return false;
  if (!frame.aipos_rad || !frame.aspos_rad) return frame.delay && delay_ && *frame.delay < *delay_;
  Eigen::Index axis = 0;
  const double largest = correction_.cwiseAbs().maxCoeff(&axis);
  const auto a = static_cast<std::size_t>(axis);
  return largest > kVisibleCorrectionRad && not_following_ == 0 &&
         std::abs((*frame.aipos_rad)[a] - (*frame.aspos_rad)[a]) < largest / 10;
}

void StreamCycle::start_session(std::uint64_t ipoc) noexcept {
  ++status_.counters.sessions;
  sequence_.start(ipoc);
  correction_.setZero();
  model_correction_.setZero();
  fade_.setZero();
  ramp_ = 0;
  fade_ramp_ = 1;
  refade_ = false;
  broken_ = unsolved_ = not_following_ = 0;
  rejected_ = implausible_ = 0;
  delay_.reset();
  last_commanded_.reset();
  last_expected_.reset();
  emit(StreamEventKind::SessionStarted, ipoc);
}

void StreamCycle::advance(std::uint64_t ipoc, const Position& position) noexcept {
  sequence_.advance(ipoc, position);
  if (position.elapsed > 1) {
    status_.counters.lost += position.elapsed - 1;
    emit(StreamEventKind::PacketsLost, position.elapsed - 1);
  }
}

std::optional<JointVector> StreamCycle::commanded_axes(const rsi::RobotFrame& frame) const noexcept {
  if (sends_aspos_) {
    if (!frame.aspos_rad) return std::nullopt;
    return vector_of(*frame.aspos_rad);
  }
  if (!frame.aipos_rad) return std::nullopt;
  return vector_of(*frame.aipos_rad) - correction_;
}

/// Whether the arm can have moved here from the frame before.
bool StreamCycle::plausible(const JointVector& commanded, const Position& position) noexcept {
  const bool far = last_commanded_ && (commanded - *last_commanded_).cwiseAbs().maxCoeff() >
                                          kGreatestMotionRad * static_cast<double>(position.elapsed);
  implausible_ = far ? implausible_ + 1 : 0;
  if (!far) return true;
  if (implausible_ < kImplausibleFrames) return false;
  implausible_ = 0;
  refade_ = true;
  return true;
}

/// False where the controller says that it did not take the last reply: changing the correction now would add
/// up to a jump when it takes the next.
bool StreamCycle::replies_arrive(const rsi::RobotFrame& frame, const Position& position,
                                 drivers::TimePoint received) noexcept {
  const std::optional<std::int64_t> before = std::exchange(delay_, frame.delay);
  if (!frame.delay || !before || *frame.delay <= *before) {
    rejected_ = 0;
    late_before_ = false;
    return true;
  }
  const std::uint64_t rise = static_cast<std::uint64_t>(*frame.delay) - static_cast<std::uint64_t>(*before);
  status_.counters.late += rise;
  if (!std::exchange(late_before_, true)) emit(StreamEventKind::RepliesLate, rise);
  const bool sent_in_time =
      position.elapsed == 1 && received_ && last_turnaround_ < kInTime && received - *received_ > kInTime;
  rejected_ = sent_in_time ? rejected_ + 1 : 0;
  if (rejected_ >= options_.rejected_cycles) raise(StreamFault::RepliesRejected);
  return false;
}

void StreamCycle::watch_following(const rsi::RobotFrame& frame, const JointVector& commanded,
                                  const Position& position) noexcept {
  // Without ASPos the commanded axes are themselves derived from AIPos, and nothing could be compared.
  if (!sends_aspos_ || !frame.aipos_rad) return;
  const JointVector expected = commanded + correction_;
  if (last_expected_ && position.elapsed > 0 && !correction_.isZero(0)) {
    const double cycles = static_cast<double>(position.elapsed);
    const JointVector motion = (expected - *last_expected_).cwiseAbs() / cycles;
    const JointVector behind =
        (vector_of(*frame.aipos_rad) - expected).cwiseAbs() - options_.following_lag_cycles * motion;
    const bool follows = behind.maxCoeff() <= options_.following_tolerance_rad;
    not_following_ = follows ? 0 : not_following_ + cycles;
    if (not_following_ >= options_.following_cycles) raise(StreamFault::NotFollowing);
  }
  last_expected_ = expected;
}

/// Brings model_correction_ up to date. @return false where the calibrated arm has no solution, or none near
bool StreamCycle::solve(const JointVector& commanded) noexcept {
  const Model& model = model_.front();
  if (model.number == 0) {
    model_correction_.setZero();
    return true;
  }
  const auto compensated = model.compensation->at_joints(commanded, model.p_F_mm);
  if (!compensated || !compensated->q.allFinite()) return false;
  model_correction_ = compensated->q - commanded;
  status_.counters.damped += compensated->damped;
  return true;
}

/// Moves the correction on by one reply. @return false where it was held instead
bool StreamCycle::correct(const JointVector& commanded, double cycles) noexcept {
  const bool engaged = engaged_.load(std::memory_order_acquire);
  const double step = cycles / options_.ramp_cycles;
  const double ramp = std::clamp(ramp_ + (engaged ? step : -step), 0.0, 1.0);
  if (ramp > 0 && !solve(commanded)) {
    ++status_.counters.no_solution;
    if (engaged) {
      refade_ = true;
      unsolved_ += cycles;
      if (unsolved_ >= options_.broken_cycles) raise(StreamFault::NoSolution);
      return false;
    }
    // On the way out the model's last wish serves: the correction must come to zero in any case.
  }
  unsolved_ = 0;
  ramp_ = ramp;
  status_.gain = smooth(ramp_);

  JointVector wanted = status_.gain * model_correction_;
  if (std::exchange(refade_, false)) {
    fade_ = correction_ - wanted;
    fade_ramp_ = 0;
  } else {
    fade_ramp_ = std::min(1.0, fade_ramp_ + step);
  }
  wanted += (1 - smooth(fade_ramp_)) * fade_;

  const BoundedCorrection bounded = bound_correction(wanted, correction_, commanded, bounds_);
  count(bounded.clamps);
  const double change_deg = (bounded.correction - correction_).cwiseAbs().maxCoeff() * kDegPerRad;
  status_.max_step_deg = std::max(status_.max_step_deg, change_deg);
  correction_ = bounded.correction;

  broken_ = engaged && bounded.clamps.broken() ? broken_ + cycles : 0;
  if (broken_ >= options_.broken_cycles) raise(StreamFault::BoundBroken);
  return !bounded.clamps.not_finite;
}

void StreamCycle::count(const CorrectionClamps& clamps) noexcept {
  StreamCounters& counters = status_.counters;
  counters.clamped_step += clamps.step;
  counters.clamped_total += clamps.total;
  counters.clamped_limit += clamps.limit;
  counters.clamped_not_finite += clamps.not_finite;
}

void StreamCycle::raise(StreamFault fault) noexcept {
  if (status_.fault == StreamFault::None) status_.fault = fault;
}

void StreamCycle::update_state() noexcept {
  const bool at_rest = ramp_ == 0 && correction_.isZero(0) && (fade_ramp_ == 1 || fade_.isZero(0));
  StreamState state = StreamState::Idle;
  if (status_.fault == StreamFault::NotFollowing) {
    state = StreamState::Frozen;
  } else if (status_.fault != StreamFault::None) {
    state = StreamState::Fault;
  } else if (engaged_.load(std::memory_order_acquire)) {
    state = ramp_ < 1 ? StreamState::RampingIn : StreamState::Active;
  } else if (!at_rest) {
    state = StreamState::RampingOut;
  }
  if (std::exchange(status_.state, state) != state) emit(StreamEventKind::StateChanged);
}

void StreamCycle::emit(StreamEventKind kind, std::uint64_t value) noexcept {
  events_.push({.kind = kind,
                .state = status_.state,
                .fault = status_.fault,
                .ipoc = sequence_.last(),
                .value = value});
}

void StreamCycle::publish() noexcept {
  for (Eigen::Index i = 0; i < kAxes; ++i) {
    status_.correction_deg[static_cast<std::size_t>(i)] = correction_[i] * kDegPerRad;
  }
  status_.ipoc = sequence_.last();
  status_.ipoc_step = sequence_.step();
  published_.back() = status_;
  published_.publish();
}

}  // namespace truepose::daemon
