#pragma once

#include <cstdint>
#include <optional>

#include "core/planted_bug.hpp"
#include "daemon/realtime/correction_in_effect.hpp"
#include "daemon/realtime/stream_memory.hpp"
#include "daemon/realtime/waiting_peer.hpp"
#include "drivers/clock.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// Whose datagrams are the controller's: those from its address, and of these from the one port that its
/// session began with. Another port is accepted only after that one has sent nothing for as long as a
/// controller needs to restart.
class PeerPin {
 public:
  /// @param address  the controller's, IPv4; none: the first that sends a good frame
  PeerPin(std::optional<std::uint32_t> address, drivers::Duration release)
      : address_{address}, release_{release} {}

  bool admits(const drivers::UdpSource& source, drivers::TimePoint now) const noexcept {
    if (planted("a source that is not pinned")) return true;
    if (address_ && source.address != *address_) return false;
    return !pinned_ || source == *pinned_ || now - heard_ >= release_;
  }

  /// An admitted source has sent a frame that can be believed.
  /// @return whether it is another one than before
  bool pin(const drivers::UdpSource& source, drivers::TimePoint now) noexcept {
    const bool other = pinned_ != source;
    if (other) {
      constexpr std::chrono::seconds kAtOnce{1};
      const bool took_over = pinned_ && pinned_->address == source.address && now - heard_ < kAtOnce;
      port_before_ = took_over ? pinned_->port : 0;
    }
    pinned_ = source;
    heard_ = now;
    return other && !planted("a source that is not pinned");
  }

  const std::optional<drivers::UdpSource>& pinned() const noexcept { return pinned_; }
  drivers::TimePoint heard() const noexcept { return heard_; }
  /// From which the same address had sent within the second before; 0: from none.
  std::uint16_t port_before() const noexcept { return port_before_; }

 private:
  std::optional<std::uint32_t> address_;
  drivers::Duration release_;
  std::optional<drivers::UdpSource> pinned_;
  drivers::TimePoint heard_;
  std::uint16_t port_before_ = 0;
};

/// Tells from a datagram's time stamp (IPOC) whether it is the next of its session, an old one, or one that
/// does not fit. The step from cycle to cycle is learned.
class IpocSequence {
 public:
  enum class Place {
    Next,       ///< continues from the last, perhaps after a gap
    Duplicate,  ///< the last once more
    Stale,      ///< from before the last, or between two cycles
    Jump,       ///< too far ahead or behind: damaged, or of a controller that restarted its count
  };
  struct Position {
    Place place = Place::Next;
    std::uint64_t forward = 0;  ///< IPOC since the last datagram; 0 where it does not lie ahead
    std::uint64_t elapsed = 1;  ///< the same in cycles
  };

  /// @param gap_cycles  a datagram further ahead than so many cycles must be borne out by others
  explicit IpocSequence(int gap_cycles) : gap_cycles_{static_cast<std::uint64_t>(gap_cycles)} {}

  bool begun() const noexcept { return begun_; }
  Position place(std::uint64_t ipoc) const noexcept;
  /// Whether a datagram that does not follow is the controller's new count all the same: the third in a row
  /// that continues from the one before it. A single one is a damaged stamp, two may have overtaken each
  /// other.
  bool bears_out(std::uint64_t ipoc) noexcept;

  /// Begins a count, of which nothing is known but the step, where the caller knows that too.
  void start(std::uint64_t ipoc, std::uint64_t step = 0) noexcept;
  void advance(std::uint64_t ipoc, const Position& position) noexcept;

  std::uint64_t last() const noexcept { return last_; }
  std::uint64_t step() const noexcept { return step_; }  ///< IPOC per cycle; 0 = not yet known

 private:
  std::uint64_t gap_cycles_;
  bool begun_ = false;
  std::uint64_t last_ = 0;
  std::uint64_t step_ = 0;
  std::uint64_t last_forward_ = 0;
  std::uint64_t other_ = 0;  // the last datagram that did not follow
  int others_ = 0;           // so many of them in a row, each after the one before
};

/// What the controller's count of cycles without a reply in time (Delay) tells of ours. Whether it adds them
/// up or counts those in a row is not documented: what is concluded here holds for both.
class ReplyReceipts {
 public:
  struct Verdict {
    bool taken = false;      ///< the reply since the count before was taken
    bool missed = false;     ///< there was a reply, and it is not known to have been taken
    bool alive = false;      ///< every cycle since is counted: the session is the same as before
    std::uint64_t late = 0;  ///< replies that were sent and came late or not at all
  };

  void restart() noexcept { *this = {}; }
  /// The count as it was when a reply to that same cycle went out, as far as is known.
  void resume(std::optional<std::int64_t> delay) noexcept {
    restart();
    before_ = delay;
    replies_ = 1;
  }
  void replied() noexcept { ++replies_; }
  std::optional<std::int64_t> last() const noexcept { return before_; }

  /// @param delay    of the frame that came now, where it has one
  /// @param elapsed  cycles since the frame before
  Verdict read(std::optional<std::int64_t> delay, std::uint64_t elapsed) noexcept;

 private:
  std::optional<std::int64_t> before_;
  std::int64_t cycles_ = 0;   // since `before_`
  std::int64_t replies_ = 0;  // sent in these cycles
};

JointVector vector_of(const rsi::Axes& axes);

struct SessionOptions {
  std::chrono::milliseconds cycle{4};                 ///< the controller's
  int gap_cycles = 100;                               ///< IpocSequence
  double step_rad = 0;                                ///< bound of a correction's change
  std::optional<std::uint32_t> peer;                  ///< the controller's IPv4 address; none: any
  drivers::TimePoint listening_since;                 ///< before, another process may have replied
  std::chrono::milliseconds greatest_dead_time{120};  ///< of the arm
  std::chrono::milliseconds greatest_lag{120};        ///< its time constant
  bool never_corrected = false;                       ///< as StreamOptions
};

/// The controller's side of the stream: who it is, where in its count it is, and what it has in effect.
/// Decides which datagrams may be answered at all. No I/O, no allocation; the realtime thread's own.
class ControllerSession {
 public:
  enum class Turn {
    Answer,     ///< what is in effect is known: reply
    Repeat,     ///< the last datagram once more: the same reply
    WrongIpoc,  ///< out of order: it belongs to no cycle that waits for a reply
    Unproven,   ///< what is in effect is not known: any reply might be a jump
    Offer,      ///< zero seems to be in effect at a peer that waits: reply zero, to see whether it takes it
  };
  struct FrameVerdict {
    Turn turn = Turn::Unproven;
    bool began = false;         ///< a session whose controller nothing is known of
    bool settled = false;       ///< the correction in effect has just become known, perhaps again
    bool missed = false;        ///< the last reply is not known to have been taken: hold
    bool taken = false;         ///< it is known to have been taken
    std::uint64_t elapsed = 0;  ///< cycles since the datagram before; 0 at the beginning
    std::uint64_t lost = 0;     ///< of these cycles those of which a datagram is missing
    std::uint64_t late = 0;     ///< replies that the controller did not have in time
  };

  /// @param memory  of the process before this one, and for the one after it; may be null
  ControllerSession(const SessionOptions& options, StreamMemory* memory);

  bool admits(const drivers::UdpSource& source, drivers::TimePoint received) const noexcept {
    return pin_.admits(source, received);
  }
  FrameVerdict judge(const rsi::RobotFrame& frame, const drivers::UdpSource& source,
                     drivers::TimePoint received) noexcept;
  /// A datagram of which no more than the IPOC can be read. @return whether the last reply may be given again
  bool judge_malformed(std::uint64_t ipoc, const drivers::UdpSource& source,
                       drivers::TimePoint received) noexcept;
  /// A reply to the datagram that was heard last goes out now.
  void reply(const JointVector& correction) noexcept;

  bool known() const noexcept { return in_effect_.known(); }
  bool peer_waits() const noexcept { return waiting_.waits(); }
  bool begun() const noexcept { return sequence_.begun(); }
  const CorrectionRange& in_effect() const noexcept { return in_effect_.range(); }
  const JointVector& last_sent() const noexcept { return in_effect_.last_sent(); }
  const std::optional<drivers::UdpSource>& peer() const noexcept { return pin_.pinned(); }
  std::uint16_t port_before() const noexcept { return pin_.port_before(); }
  std::uint64_t ipoc() const noexcept { return sequence_.last(); }
  std::uint64_t step() const noexcept { return sequence_.step(); }

 private:
  void begin(const rsi::RobotFrame& frame) noexcept;
  void judge_again(const rsi::RobotFrame& frame, FrameVerdict& verdict) noexcept;
  bool no_correction_in_effect(const rsi::RobotFrame& frame) const noexcept;
  void continue_session(const rsi::RobotFrame& frame, const IpocSequence::Position& position,
                        FrameVerdict& verdict) noexcept;
  void settle(const rsi::RobotFrame& frame, std::uint64_t forward, FrameVerdict& verdict) noexcept;
  bool began_in_our_silence(const rsi::RobotFrame& frame) const noexcept;

  SessionOptions options_;
  std::uint64_t restart_cycles_;
  StreamMemory* memory_;
  PeerPin pin_;
  IpocSequence sequence_;
  ReplyReceipts receipts_;
  CorrectionInEffect in_effect_;
  EffectEvidence evidence_;
  WaitingPeer waiting_;
  bool from_zero_ = false;         // the count of this session began with the frame that was heard last
  bool offered_ = false;           // zero, to the frame that was heard last
  bool in_next_cycle_ = false;     // what is doubted is one reply later than what was known
  bool replied_ = false;           // to this frame, by this process
  bool corrected_;                 // ever, by this or another process: not with zero alone
  int fewer_counted_ = 0;          // frames in a row that show a controller that began in our silence
  drivers::TimePoint received_{};  // of the datagram that is heard
  drivers::TimePoint received_before_{};  // of the one of this session before it
  drivers::TimePoint silent_since_;       // no reply was sent since
};

}  // namespace truepose::daemon
