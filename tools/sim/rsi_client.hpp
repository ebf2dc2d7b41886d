#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/kinematics/robot_model.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "tools/sim/kuka_controller.hpp"
#include "tools/sim/stream_path.hpp"

namespace truepose::sim {

struct RsiSetup {
  RobotModel nominal;
  rsi::EthernetConfig ethernet;
  std::chrono::milliseconds cycle{4};
  int timeout_cycles = 100;            ///< ETHERNET object's Timeout
  double axis_corr_limit_rad = 0.087;  ///< AXISCORR clamps larger corrections silently
};

/// What the controller counts. Every cycle is answered, or its answer came late, or it was lost.
struct RsiCounters {
  std::uint64_t cycles = 0;
  std::uint64_t answered = 0;    ///< in time, and believed
  std::uint64_t late = 0;        ///< after their cycle had ended: ignored
  std::uint64_t lost = 0;        ///< no answer so far
  std::uint64_t wrong_ipoc = 0;  ///< replies to no cycle that still waits for one
  std::uint64_t rejected = 0;    ///< replies that are malformed or not of the configured SENTYPE
  std::uint64_t clamped = 0;     ///< cycles in which AXISCORR clamped an axis
  double max_step_rad = 0;       ///< greatest change of an axis' correction from one cycle to the next
  double correction_rad = 0;     ///< greatest correction of an axis that is in force now, or was at the end
};

/// The RSI objects of a simulated controller (ETHERNET, AXISCORR, STOP), one cycle at a time. No I/O and no
/// clock.
///
/// A cycle is begin_cycle(), receive() for every datagram that comes in meanwhile, end_cycle().
class RsiClient {
 public:
  RsiClient(RsiSetup setup, StreamPath path, std::uint64_t first_ipoc);

  /// Moves the programmed path on. @return the datagram to send, valid until the next call
  std::string_view begin_cycle();

  enum class Reply { Valid, Late, WrongIpoc, Rejected };
  struct Verdict {
    Reply reply;
    std::uint64_t cycles_ago = 0;  ///< how long ago the answered datagram was sent
  };
  Verdict receive(std::string_view datagram);

  /// Applies the cycle's reply, or HOLDON where there was none.
  /// @return why RSI has ended, if it has
  std::optional<RsiEnd> end_cycle();

  JointVector axes() const;  ///< actual: programmed plus correction
  bool moving() const { return path_.moving(); }
  bool answered() const { return reply_.has_value(); }
  const RsiCounters& counters() const { return counters_; }

 private:
  // Late answers are recognised this many cycles back.
  static constexpr std::size_t kRemembered = 1024;

  rsi::Axes held() const;
  void apply(const rsi::Axes& wanted_rad);

  RsiSetup setup_;
  rsi::SensorFrameCodec codec_;
  std::array<bool, 6> hold_on_{};
  StreamPath path_;
  rsi::Axes correction_rad_{};
  std::uint64_t first_ipoc_;
  std::uint64_t ipoc_;
  std::array<bool, kRemembered> open_{};  // cycles that wait for an answer
  std::optional<rsi::SensorFrame> reply_;
  int unanswered_in_a_row_ = 0;
  RsiCounters counters_;
  std::array<char, rsi::kMaxFrameBytes> buffer_{};
};

}  // namespace truepose::sim
