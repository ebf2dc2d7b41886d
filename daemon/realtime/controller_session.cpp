#include "daemon/realtime/controller_session.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace truepose::daemon {

namespace {

constexpr std::uint64_t kWrap32 = std::uint64_t{1} << 32;

using Place = IpocSequence::Place;

// Leaving and restarting RSI takes the controller's interpreter longer than this.
constexpr std::chrono::milliseconds kShortestRestart{40};
// A datagram later than its IPOC says may belong to a restarted count that reached the same numbers.
constexpr std::chrono::milliseconds kLateForItsIpoc{100};

// One frame may be damaged.
constexpr int kFramesThatProve = 3;

ArmLag lag_of(const SessionOptions& options) {
  const auto cycle_ms = static_cast<double>(options.cycle.count());
  return {.dead_cycles =
              static_cast<int>(std::ceil(static_cast<double>(options.greatest_dead_time.count()) / cycle_ms)),
          .lag_cycles = static_cast<double>(options.greatest_lag.count()) / cycle_ms};
}

}  // namespace

IpocSequence::Position IpocSequence::place(std::uint64_t ipoc) const noexcept {
  if (!begun_) return {.place = Place::Jump};
  if (ipoc == last_) return {.place = Place::Duplicate};

  const std::uint64_t window = std::max<std::uint64_t>(step_, 1) * gap_cycles_;
  std::uint64_t forward = ipoc - last_;
  if (ipoc < last_) {
    // Some controllers count in 32 bits, which are full after 49 days: no reason to let go of the correction.
    const bool wrapped = last_ < kWrap32 && kWrap32 - last_ <= window && ipoc < window;
    if (!wrapped) return {.place = last_ - ipoc <= window ? Place::Stale : Place::Jump};
    forward = kWrap32 - last_ + ipoc;
  }
  const std::uint64_t step = step_ == 0 ? forward : step_;
  if (forward < step / 2) return {.place = Place::Stale};  // no tick of the controller
  const std::uint64_t elapsed =
      std::max<std::uint64_t>(1, forward / step + (forward % step > step / 2 ? 1 : 0));
  return {.place = elapsed > gap_cycles_ ? Place::Jump : Place::Next, .forward = forward, .elapsed = elapsed};
}

bool IpocSequence::bears_out(std::uint64_t ipoc) noexcept {
  constexpr std::uint64_t kSoon = 1000;
  const bool goes_on = others_ > 0 && ipoc > other_ && ipoc - other_ < kSoon;
  others_ = goes_on ? others_ + 1 : 1;
  other_ = ipoc;
  return !begun_ || others_ >= 3;
}

void IpocSequence::start(std::uint64_t ipoc, std::uint64_t step) noexcept {
  begun_ = true;
  last_ = ipoc;
  step_ = step;
  last_forward_ = 0;
  others_ = 0;
}

void IpocSequence::advance(std::uint64_t ipoc, const Position& position) noexcept {
  last_ = ipoc;
  others_ = 0;
  // The smallest step that was seen twice in a row: not a gap, not a damaged time stamp.
  const bool again = std::exchange(last_forward_, position.forward) == position.forward;
  if (again && (step_ == 0 || position.forward < step_)) step_ = position.forward;
}

ReplyReceipts::Verdict ReplyReceipts::read(std::optional<std::int64_t> delay,
                                           std::uint64_t elapsed) noexcept {
  cycles_ += static_cast<std::int64_t>(elapsed);
  Verdict verdict{.missed = replies_ > 0};
  if (!delay) return verdict;

  const std::optional<std::int64_t> before = std::exchange(before_, delay);
  const std::int64_t cycles = std::exchange(cycles_, 0), replies = std::exchange(replies_, 0);
  if (!before) return verdict;
  const std::int64_t rise = *delay - *before;
  // With one reply among the cycles, and it was taken: a sum has risen by the others, a count of those in a
  // row is at most the others. If it was not, a sum has risen by all of them, and the count is all of them at
  // least. With more replies a count of those in a row no longer tells which was taken.
  verdict.taken = replies == 1 && (rise == cycles - 1 || *delay <= cycles - 1);
  verdict.missed = replies > 0 && !verdict.taken;
  verdict.alive = cycles > 0 && rise >= cycles - replies;
  verdict.late = static_cast<std::uint64_t>(std::max<std::int64_t>(0, rise - (cycles - replies)));
  return verdict;
}

JointVector vector_of(const rsi::Axes& axes) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 1>>(axes.data());
}

ControllerSession::ControllerSession(const SessionOptions& options, StreamMemory* memory)
    : options_{options},
      restart_cycles_{static_cast<std::uint64_t>(std::max<std::int64_t>(
          2, (kShortestRestart + options.cycle - std::chrono::milliseconds{1}) / options.cycle))},
      memory_{memory},
      pin_{options.peer, kShortestRestart},
      sequence_{options.gap_cycles},
      evidence_{lag_of(options)},
      corrected_{!options.never_corrected},
      silent_since_{options.listening_since} {
  const auto kept = memory_ ? memory_->last() : std::nullopt;
  if (!kept) return;
  received_before_ = drivers::TimePoint{std::chrono::nanoseconds{kept->received_ns}};
  silent_since_ = received_before_;
  const drivers::UdpSource source{kept->address, static_cast<std::uint16_t>(kept->port)};
  if (!pin_.admits(source, received_before_)) return;
  pin_.pin(source, received_before_);
  sequence_.start(kept->ipoc, kept->step);
  receipts_.resume(kept->delay < 0 ? std::nullopt : std::optional{kept->delay});
  in_effect_.resume({vector_of(kept->min_rad), vector_of(kept->max_rad)}, vector_of(kept->sent_rad));
  corrected_ = true;
}

ControllerSession::FrameVerdict ControllerSession::judge(const rsi::RobotFrame& frame,
                                                         const drivers::UdpSource& source,
                                                         drivers::TimePoint received) noexcept {
  received_ = received;
  const bool other = pin_.pin(source, received);
  if (other) waiting_.restart();
  waiting_.take(frame.ipoc, received);
  FrameVerdict verdict;
  if (other || !sequence_.begun()) {
    begin(frame);
    verdict.began = true;
    settle(frame, 0, verdict);
    return verdict;
  }

  const IpocSequence::Position position = sequence_.place(frame.ipoc);
  const bool borne_out = (position.place == Place::Jump || position.place == Place::Stale) &&
                         (sequence_.bears_out(frame.ipoc) || waiting_.waits());
  if (position.place == Place::Duplicate) {
    judge_again(frame, verdict);
  } else if (position.place == Place::Next ||
             (borne_out && position.forward > 0 && position.place == Place::Jump && !waiting_.waits())) {
    continue_session(frame, position, verdict);
  } else if (borne_out) {
    begin(frame);
    verdict.began = true;
    settle(frame, 0, verdict);
  } else {
    verdict.turn = Turn::WrongIpoc;
  }
  return verdict;
}

/// The last frame once more. What a waiting peer has in effect is what it had when it began to wait.
void ControllerSession::judge_again(const rsi::RobotFrame& frame, FrameVerdict& verdict) noexcept {
  const bool waits = waiting_.waits();
  if (in_effect_.doubtful() && waits && in_next_cycle_) {
    // One that was started again meanwhile would stand where its count of replies begins.
    in_effect_.trust();
    verdict.settled = true;
  }
  if (known() && (replied_ || !waits)) {
    verdict.turn = Turn::Repeat;
  } else if (known()) {
    verdict.turn = Turn::Answer;
    verdict.missed = true;
  } else if (waits && no_correction_in_effect(frame)) {
    offered_ = true;
    receipts_.restart();
    receipts_.read(frame.delay, 0);
    verdict.turn = Turn::Offer;
  }
  // It counts no time while it waits.
  if (waits && verdict.turn != Turn::Unproven) received_before_ = received_;
}

/// Whether a peer that waits can have no correction in effect. Where none was ever sent, by whichever
/// process, axes that stand where they are commanded prove it. Else they do not: within a dead time they have
/// not yet gone where a correction leads them, and a peer that waits is within it as long as it gets no
/// answer. But a count of replies that is still 0 does.
bool ControllerSession::no_correction_in_effect(const rsi::RobotFrame& frame) const noexcept {
  if (!frame.delay) return false;  // it could not show that the offer was taken
  if (from_zero_) return true;
  if (corrected_ && !planted("a waiting peer has no correction in effect")) return false;
  if (!frame.aspos_rad || !frame.aipos_rad) return false;
  return (vector_of(*frame.aspos_rad) - vector_of(*frame.aipos_rad)).cwiseAbs().maxCoeff() <=
         ArmLag{}.noise_rad;
}

void ControllerSession::begin(const rsi::RobotFrame& frame) noexcept {
  sequence_.start(frame.ipoc);
  from_zero_ = frame.ipoc == 0;
  offered_ = in_next_cycle_ = replied_ = false;
  receipts_.restart();
  receipts_.read(frame.delay, 0);
  in_effect_.forget();
  evidence_.restart();
  fewer_counted_ = 0;
  received_before_ = received_;
}

void ControllerSession::continue_session(const rsi::RobotFrame& frame, const IpocSequence::Position& position,
                                         FrameVerdict& verdict) noexcept {
  const ReplyReceipts::Verdict receipt = receipts_.read(frame.delay, position.elapsed);
  if (receipt.taken) in_effect_.taken();
  verdict.elapsed = position.elapsed;
  verdict.missed = receipt.missed;
  if (planted("a limit from the last datagram, not from what is in effect")) verdict.missed = false;
  verdict.taken = receipt.taken;
  verdict.late = receipt.late;

  // Where IPOC and time agree, the count of cycles without a reply separates a session that continued from
  // one that began meanwhile: that one has counted fewer.
  const auto silence = received_ - received_before_;
  const auto cycles = static_cast<std::int64_t>(position.elapsed);
  // A count that has jumped says nothing of datagrams that were sent.
  const auto passed = static_cast<std::uint64_t>(std::max<std::int64_t>(0, silence / options_.cycle));
  verdict.lost = std::min(position.elapsed - 1, passed + static_cast<std::uint64_t>(options_.gap_cycles));
  const bool longer_than_counted = silence >= cycles * options_.cycle + kLateForItsIpoc;
  const bool long_silence = position.elapsed >= restart_cycles_;
  if (longer_than_counted || (long_silence && !receipt.alive)) {
    in_next_cycle_ = known() && position.forward == sequence_.step();
    in_effect_.doubt();
    evidence_.restart();
    fewer_counted_ = 0;
  } else {
    in_next_cycle_ = false;
  }
  // The step is not known yet: of a count of replies or of milliseconds.
  const bool next =
      position.forward == 1 || position.forward == static_cast<std::uint64_t>(options_.cycle.count());
  if (std::exchange(offered_, false) && next &&
      (receipt.taken || planted("a waiting peer has taken what it was offered"))) {
    in_effect_.set(CorrectionRange::of(JointVector::Zero(6)));
    verdict.settled = true;
  }
  if (planted("a timeout of the controller that is a constant") && position.elapsed > 100)
    in_effect_.set(CorrectionRange::of(JointVector::Zero(6)));
  from_zero_ = replied_ = false;
  sequence_.advance(frame.ipoc, position);
  received_before_ = received_;
  settle(frame, position.forward, verdict);
}

void ControllerSession::settle(const rsi::RobotFrame& frame, std::uint64_t forward,
                               FrameVerdict& verdict) noexcept {
  verdict.turn = Turn::Answer;
  if (known()) return;
  if (frame.aspos_rad && frame.aipos_rad) {
    // Sooner, the axes may still show what was in effect at some time before our last reply.
    if (received_ - silent_since_ >= options_.greatest_dead_time)
      evidence_.take(vector_of(*frame.aspos_rad), vector_of(*frame.aipos_rad), forward);
    verdict.settled = in_effect_.settle(evidence_, options_.step_rad);
  } else {
    fewer_counted_ = began_in_our_silence(frame) ? fewer_counted_ + 1 : 0;
    if (fewer_counted_ >= kFramesThatProve) {
      in_effect_.set(CorrectionRange::of(JointVector::Zero(6)));
      verdict.settled = true;
    }
  }
  if (!known()) verdict.turn = Turn::Unproven;
}

/// Where the commanded axes are not sent nothing can be compared. But a controller that has counted fewer
/// cycles without a reply than passed since we sent the last began after it, and had nothing in effect then.
bool ControllerSession::began_in_our_silence(const rsi::RobotFrame& frame) const noexcept {
  if (!frame.delay || *frame.delay < 0) return false;
  const auto counted = *frame.delay * options_.cycle + kShortestRestart;
  return received_ - silent_since_ >= counted;
}

bool ControllerSession::judge_malformed(std::uint64_t ipoc, const drivers::UdpSource& source,
                                        drivers::TimePoint received) noexcept {
  waiting_.restart();
  if (!known() || pin_.pinned() != source) return false;
  const IpocSequence::Position position = sequence_.place(ipoc);
  if (position.place == Place::Duplicate) return true;
  // After a gap the controller may have restarted at zero; this frame does not show it.
  if (position.place != Place::Next || position.elapsed >= restart_cycles_) return false;
  if (received - received_before_ >= kShortestRestart) return false;
  receipts_.read(std::nullopt, position.elapsed);
  sequence_.advance(ipoc, position);
  received_before_ = received_ = received;
  return true;
}

void ControllerSession::reply(const JointVector& correction) noexcept {
  receipts_.replied();
  silent_since_ = received_;
  if (offered_) return;  // nothing is known yet that another process could count from
  replied_ = true;
  corrected_ = corrected_ || !correction.isZero(0);
  in_effect_.sent(correction);
  if (!memory_) return;
  StreamMemory::Record record{.address = pin_.pinned()->address,
                              .port = pin_.pinned()->port,
                              .ipoc = sequence_.last(),
                              .step = sequence_.step(),
                              .received_ns = std::chrono::nanoseconds{received_.time_since_epoch()}.count(),
                              .delay = receipts_.last().value_or(-1)};
  std::copy(correction.begin(), correction.end(), record.sent_rad.begin());
  std::copy(in_effect_.range().min.begin(), in_effect_.range().min.end(), record.min_rad.begin());
  std::copy(in_effect_.range().max.begin(), in_effect_.range().max.end(), record.max_rad.begin());
  memory_->keep(record);
}

}  // namespace truepose::daemon
