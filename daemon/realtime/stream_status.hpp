#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/fault_text.hpp"
#include "daemon/log/log.hpp"
#include "drivers/clock.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

enum class StreamState : std::uint8_t {
  Idle,
  Unproven,  ///< packets come, but what the controller has in effect is not known: none is answered
  RampingIn,
  Active,
  RampingOut,
  Frozen,
  Fault,
};

/// Why the stream holds its correction until it is acknowledged.
enum class StreamFault : std::uint8_t {
  None,
  NotFollowing,  ///< frozen: the axes do not follow the correction
  BoundBroken,  ///< the model asked for more than the bounds allow, for long; the controller is asked to stop
  NoSolution,   ///< the calibrated arm could not be inverted, or not near, for long; the controller is asked
                ///< to stop
  RepliesRejected,  ///< the controller counts replies as late that were sent in time
  WrongCycle,       ///< the controller's IPOC does not rise by the configured cycle
  NotSent,     ///< no frame has an element that the configuration sends, and that the stream is watched by
  WrongArm,    ///< RIst is not where the nominal arm's flange is at AIPos
  JointLimit,  ///< an axis is beyond its limit, for long, or its correction leads there; the controller is
               ///< asked to stop
};
inline constexpr std::array kStreamFaults{StreamFault::NotFollowing, StreamFault::BoundBroken,
                                          StreamFault::NoSolution,   StreamFault::RepliesRejected,
                                          StreamFault::WrongCycle,   StreamFault::NotSent,
                                          StreamFault::WrongArm,     StreamFault::JointLimit};  ///< but None

std::string_view name(StreamState state);
inline constexpr std::array kStreamStates{
    StreamState::Idle,       StreamState::Unproven, StreamState::RampingIn, StreamState::Active,
    StreamState::RampingOut, StreamState::Frozen,   StreamState::Fault};

/// What a fault is about, as far as it has an axis and numbers.
struct FaultDetail {
  int axis = 0;      ///< 1..6; 0 = none
  double value = 0;  ///< deg, of JointLimit with its correction; WrongCycle: the IPOC's step; WrongArm: mm
  double limit = 0;  ///< in the same unit
  double uncertain = 0;        ///< NotFollowing: value is known to so much
  std::string_view element{};  ///< NotSent: its name, a constant
  std::array<std::uint16_t, 2>
      ports{};  ///< WrongCycle: from one and then the other the controller's address sent
};

struct FoundFault {
  StreamFault fault = StreamFault::None;
  FaultDetail detail{};
};

/// Every datagram of the controller is in exactly one of answered, held, duplicate, wrong_ipoc, unconfirmed
/// and unanswered.
struct StreamCounters {
  std::uint64_t datagrams = 0;  ///< of the controller alone
  std::uint64_t answered = 0;   ///< with a correction of its own cycle (zero while idle)
  std::uint64_t held =
      0;  ///< with the last correction, because the frame, the model or a latched fault forbade another
  std::uint64_t duplicate = 0;    ///< a repeated IPOC, given the same reply
  std::uint64_t wrong_ipoc = 0;   ///< out of order, or repeated and there is no reply to repeat; not answered
  std::uint64_t unconfirmed = 0;  ///< not answered, because what the controller has in effect was not known
  std::uint64_t unanswered = 0;   ///< malformed, and nothing to hold on to
  std::uint64_t malformed = 0;  ///< frames that could not be believed (among held, duplicate and unanswered)
  std::uint64_t partly_read =
      0;  ///< frames with an element that could not be read, and is not what is corrected by
  std::uint64_t unexpected_sender =
      0;                          ///< datagrams of others than the controller, dropped (in no other figure)
  std::uint64_t no_solution = 0;  ///< cycles in which the calibrated arm was not inverted, or not near
  std::uint64_t damped = 0;       ///< cycles that gave up orientation next to the wrist singularity
  std::uint64_t lost = 0;         ///< cycles missing in the controller's IPOC
  std::uint64_t late = 0;  ///< replies that were sent and that the controller did not have in time (Delay)
  std::uint64_t late_by_daemon = 0, late_by_machine = 0, late_by_network = 0;  ///< replies, see Lateness
  std::uint64_t sessions = 0;  ///< starts of the controller's side
  std::uint64_t clamped_step = 0, clamped_total = 0, clamped_limit = 0, clamped_not_finite = 0;

  std::uint64_t replies() const { return answered + held + duplicate; }
};

/// The stream as of its last datagram.
struct StreamStatus {
  StreamState state = StreamState::Idle;
  StreamFault fault = StreamFault::None;
  FaultDetail detail;              ///< of the fault
  std::uint32_t acknowledged = 0;  ///< so many acknowledgements were taken
  StreamCounters counters;
  std::optional<drivers::TimePoint> heard;  ///< when the controller's last good frame came in
  drivers::TimePoint read_until{};          ///< all that it had sent by then has been read
  std::optional<drivers::UdpSource> peer;   ///< the controller, as it sends
  std::uint64_t ipoc = 0;
  std::uint64_t ipoc_step = 0;  ///< learned from the controller; 0 = not yet known
  bool peer_waits = false;      ///< it repeats its frame until it is answered, as simulators do
  std::uint64_t model = 0;      ///< number that use_model() was given; 0 = none
  double gain = 0;              ///< 0 = no correction, 1 = all of it
  // ProgramSignals, where the last frame had them.
  std::optional<std::int64_t> program, mode, override_percent, cell;
  // What the robot program says, where the controller sends it.
  bool program_stopped = false;   ///< the correction is held until it continues
  bool program_declines = false;  ///< of an armed stream: it does not ask to be corrected
  double max_step_deg = 0;        ///< greatest change of an axis that was sent from one cycle to the next
  std::array<double, 6> correction_deg{};  ///< sent last
  /// The part of AIPos - ASPos over the last second that is not lag or motion; none if it cannot be
  /// separated.
  std::array<std::optional<double>, 6> measured_deg{};
  std::array<double, 6> commanded_deg{};  ///< axes that the robot program commands
};

/// For how long the controller is known to have sent no good frame; none where it never has sent one. Shorter
/// than the frame's age where this machine does not read what came.
std::optional<drivers::Duration> silence(const StreamStatus& status);

/// Of the stream's fault; empty where it has none.
FaultText fault_text(const StreamStatus& status);

/// One sentence for the operator, with what to do; empty where the stream does what it should.
std::string reason(const StreamStatus& status);

enum class StreamEventKind : std::uint8_t {
  SessionStarted,  ///< value = IPOC; source
  SessionProven,   ///< what is in effect is known; value = greatest of it on an axis, microdegrees
  StateChanged,    ///< state, fault and detail as they are now
  Malformed,       ///< the first of a session, or of a row; source, bytes, error
  PartlyRead,      ///< the first of a session that has an element which cannot be read; source, bytes, error
  PacketsLost,     ///< value = cycles
  RepliesLate,     ///< value = how many
  ModelChanged,    ///< value = its number
  Foreign,         ///< a datagram of an unexpected sender, once for each address; source
  Disarmed,        ///< the controller was silent for long; value = milliseconds
};
inline constexpr std::size_t kStreamEventKinds = 10;

/// Part of a datagram, for people.
struct Excerpt {
  std::array<char, 80> bytes{};
  std::size_t begin = 0;  ///< in the datagram
  std::size_t size = 0;

  /// @param at  a byte of the datagram, which is in the middle where there is enough on both sides
  static Excerpt of(std::string_view datagram, std::size_t at) {
    Excerpt excerpt;
    const std::size_t most = excerpt.bytes.size();
    const std::size_t last = datagram.size() > most ? datagram.size() - most : 0;
    excerpt.begin = std::min(at > most / 2 ? at - most / 2 : 0, last);
    excerpt.size = datagram.copy(excerpt.bytes.data(), most, excerpt.begin);
    return excerpt;
  }
  /// What is not printable ASCII as '.'.
  std::string text() const;
};

/// What the realtime thread tells the others, who log it.
struct StreamEvent {
  StreamEventKind kind = StreamEventKind::StateChanged;
  StreamState state = StreamState::Idle;
  StreamFault fault = StreamFault::None;
  FaultDetail detail{};
  std::uint64_t ipoc = 0;
  std::uint64_t value = 0;
  drivers::UdpSource source{};
  Excerpt excerpt{};
  rsi::FrameError error{};  ///< its views point to constants
};

/// One event as a line for people.
std::string describe(const StreamEvent& event);

/// Puts the realtime thread's events into words for people. A bad network makes many events: after one of a
/// kind is said, what follows within kQuiet is added up and said in one line at its end. Changes of the state
/// and of the model come from people, and are all said.
class StreamLog {
 public:
  using Say = std::function<void(LogLevel level, const std::string& line)>;
  static constexpr std::chrono::seconds kQuiet{10};

  explicit StreamLog(Say say) : say_{std::move(say)} {}

  void take(const StreamEvent& event, drivers::TimePoint now);
  /// Says what was added up, once its time has come. Call often.
  /// @param dropped  events so far for which there was no room (StreamCycle::dropped_events())
  void pass(std::uint64_t dropped, drivers::TimePoint now);

 private:
  /// Of one kind, since the last line about it.
  struct Silence {
    bool begun = false;
    drivers::TimePoint end;
    std::uint64_t events = 0;
    std::uint64_t values = 0;
  };

  /// After kQuiet: says the sum, and is silent for as long again, or ends where there is none.
  void end_silence(StreamEventKind kind, drivers::TimePoint now);

  Say say_;
  std::array<Silence, kStreamEventKinds> silences_;
  std::uint64_t dropped_ = 0;
};

}  // namespace truepose::daemon
