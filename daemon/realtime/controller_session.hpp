#pragma once

#include <optional>

#include "daemon/realtime/correction_in_force.hpp"
#include "daemon/realtime/effect_evidence.hpp"
#include "daemon/realtime/ipoc_sequence.hpp"
#include "daemon/realtime/peer_pin.hpp"
#include "daemon/realtime/reply_receipts.hpp"
#include "daemon/realtime/stream_memory.hpp"
#include "drivers/clock.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

JointVector vector_of(const rsi::Axes& axes);

struct SessionOptions {
  std::chrono::milliseconds cycle{4};                 ///< the controller's
  int gap_cycles = 100;                               ///< IpocSequence
  double step_rad = 0;                                ///< bound of a correction's change
  std::optional<std::uint32_t> peer;                  ///< the controller's IPv4 address; none: any
  drivers::TimePoint listening_since;                 ///< before, another process may have replied
  std::chrono::milliseconds greatest_dead_time{120};  ///< of the arm
  std::chrono::milliseconds greatest_lag{120};        ///< its time constant
};

/// The controller's side of the stream: who it is, where in its count it is, and what it has in force.
/// Decides which datagrams may be answered at all. No I/O, no allocation; the realtime thread's own.
class ControllerSession {
 public:
  enum class Turn {
    Answer,     ///< what is in force is known: reply
    Repeat,     ///< the last datagram once more: the same reply
    WrongIpoc,  ///< out of order: it belongs to no cycle that waits for a reply
    Unproven,   ///< what is in force is not known: any reply might be a jump
  };
  struct Hearing {
    Turn turn = Turn::Unproven;
    bool began = false;         ///< a session whose controller nothing is known of
    bool settled = false;       ///< what is in force has just become known, perhaps anew
    bool missed = false;        ///< the last reply is not known to have been taken: hold
    std::uint64_t elapsed = 0;  ///< cycles since the datagram before; 0 at the beginning
    std::uint64_t late = 0;     ///< replies that the controller did not have in time
  };

  /// @param memory  of the process before this one, and for the one after it; may be null
  ControllerSession(const SessionOptions& options, StreamMemory* memory);

  bool admits(const drivers::UdpSource& source, drivers::TimePoint received) const noexcept {
    return pin_.admits(source, received);
  }
  Hearing hear(const rsi::RobotFrame& frame, const drivers::UdpSource& source,
               drivers::TimePoint received) noexcept;
  /// A datagram of which no more than the IPOC can be read. @return whether the last reply may be given again
  bool hear_malformed(std::uint64_t ipoc, const drivers::UdpSource& source,
                      drivers::TimePoint received) noexcept;
  /// A reply to the datagram that was heard last goes out now.
  void reply(const JointVector& correction) noexcept;

  bool known() const noexcept { return in_force_.known(); }
  bool begun() const noexcept { return sequence_.begun(); }
  const CorrectionRange& in_force() const noexcept { return in_force_.range(); }
  const JointVector& last_sent() const noexcept { return in_force_.last_sent(); }
  const std::optional<drivers::UdpSource>& peer() const noexcept { return pin_.pinned(); }
  std::uint64_t ipoc() const noexcept { return sequence_.last(); }
  std::uint64_t step() const noexcept { return sequence_.step(); }

  /// Cycles of a silence in which a controller can leave RSI and begin anew.
  std::uint64_t restart_cycles() const noexcept { return restart_cycles_; }

 private:
  void begin(const rsi::RobotFrame& frame) noexcept;
  void go_on(const rsi::RobotFrame& frame, const IpocSequence::Position& position, Hearing& hearing) noexcept;
  void settle(const rsi::RobotFrame& frame, std::uint64_t forward, Hearing& hearing) noexcept;
  bool began_in_our_silence(const rsi::RobotFrame& frame) const noexcept;

  SessionOptions options_;
  std::uint64_t restart_cycles_;
  StreamMemory* memory_;
  PeerPin pin_;
  IpocSequence sequence_;
  ReplyReceipts receipts_;
  CorrectionInForce in_force_;
  EffectEvidence evidence_;
  int fewer_counted_ = 0;  // frames in a row that show a controller that began in our silence
  drivers::TimePoint received_{};         // of the datagram that is heard
  drivers::TimePoint received_before_{};  // of the one of this session before it
  drivers::TimePoint silent_since_;       // no reply was sent since
};

}  // namespace truepose::daemon
