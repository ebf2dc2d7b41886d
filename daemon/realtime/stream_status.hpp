#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace truepose::daemon {

enum class StreamState : std::uint8_t { Idle, RampingIn, Active, RampingOut, Frozen, Fault };

/// Why the stream holds its correction until it is acknowledged.
enum class StreamFault : std::uint8_t {
  None,
  NotFollowing,  ///< frozen: the axes do not follow, the robot program is stopped
  BoundBroken,  ///< the model asked for more than the bounds allow, for long; the controller is asked to stop
  NoSolution,   ///< the calibrated arm could not be inverted, or not near, for long; the controller is asked
                ///< to stop
  RepliesRejected,  ///< the controller counts replies as late that were sent in time
};

std::string_view name(StreamState state);
/// One sentence for the operator, with what to do; empty for None.
std::string_view reason(StreamFault fault);

/// Every datagram is in exactly one of answered, held, duplicate, stale and unanswered.
struct StreamCounters {
  std::uint64_t datagrams = 0;
  std::uint64_t answered = 0;  ///< with a correction of its own cycle (zero while idle)
  std::uint64_t held =
      0;  ///< with the last correction, because the frame, the model or a latched fault forbade another
  std::uint64_t duplicate = 0;    ///< a repeated IPOC, given the same reply
  std::uint64_t stale = 0;        ///< an IPOC from before the last one, given the last correction
  std::uint64_t unanswered = 0;   ///< no readable IPOC, or a bad frame after a silence
  std::uint64_t malformed = 0;    ///< frames that could not be believed (among held and unanswered)
  std::uint64_t no_solution = 0;  ///< cycles in which the calibrated arm could not be inverted, or not near
  std::uint64_t damped = 0;       ///< cycles that gave up orientation next to the wrist singularity
  std::uint64_t lost = 0;         ///< cycles missing in the controller's IPOC
  std::uint64_t late = 0;         ///< replies that the controller counted as late (Delay)
  std::uint64_t sessions = 0;     ///< starts of the controller's side
  std::uint64_t clamped_step = 0, clamped_total = 0, clamped_limit = 0, clamped_not_finite = 0;
};

/// The stream as of its last datagram.
struct StreamStatus {
  StreamState state = StreamState::Idle;
  StreamFault fault = StreamFault::None;
  StreamCounters counters;
  std::uint64_t ipoc = 0;
  std::uint64_t ipoc_step = 0;  ///< learned from the controller; 0 = not yet known
  std::uint64_t model = 0;      ///< number that use_model() was given; 0 = none
  double gain = 0;              ///< 0 = no correction, 1 = all of it
  double max_step_deg = 0;      ///< greatest change of an axis that was sent from one cycle to the next
  std::array<double, 6> correction_deg{};  ///< in force
  std::array<double, 6> commanded_deg{};   ///< axes that the robot program commands
};

enum class StreamEventKind : std::uint8_t {
  SessionStarted,  ///< value = IPOC
  StateChanged,    ///< state and fault as they are now
  Malformed,       ///< the first of a row of bad frames
  PacketsLost,     ///< value = cycles
  RepliesLate,     ///< value = by how much Delay rose
  ModelChanged,    ///< value = its number
};
inline constexpr std::size_t kStreamEventKinds = 6;

/// What the realtime thread tells the others, who log it.
struct StreamEvent {
  StreamEventKind kind = StreamEventKind::StateChanged;
  StreamState state = StreamState::Idle;
  StreamFault fault = StreamFault::None;
  std::uint64_t ipoc = 0;
  std::uint64_t value = 0;
};

}  // namespace truepose::daemon
