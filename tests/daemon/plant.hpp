#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace truepose::test {

/// What a controller counts of its unanswered cycles: all of the session, those since the last answer, or
/// nothing.
enum class Count { None, Cumulative, Consecutive };

struct PlantOptions {
  double cycle_ms = 4;
  std::uint64_t ipoc_step = 4;
  double dead_time_ms = 0;  ///< from a set point to the first motion, up to kMaxDeadTimeCycles cycles
  double lag_ms = 0;        ///< time constant of the drives' first-order lag
  std::array<double, 6> axis_lag_scale{1, 1, 1, 1, 1, 1};  ///< of the lag, axis by axis
  int timeout_cycles = 100;
  Count timeout_counts = Count::Consecutive;  ///< Cumulative or Consecutive
  bool holdon = true;
  Count delay = Count::Cumulative;  ///< what DEF_Delay says; None: it is not sent
  double axis_corr_limit_deg = 5;   ///< AXISCORR clamps to it silently
  bool ignores_correction = false;  ///< takes the replies, and moves nothing by them
  std::uint64_t first_ipoc = 4'208'163;
  std::uint16_t source_port = 49'152;
};

/// A KUKA controller's RSI and the drives behind it, one interpolation cycle at a time: plain numbers in and
/// out, no time but its own, nothing allocated. It is the oracle that the stream is judged by, and shares no
/// code with the product or with truepose-sim.
///
/// A cycle is begin_cycle(), take_reply() for every reply that comes in meanwhile, end_cycle(). The
/// correction taken in a cycle moves the axes from the next one on, after the drives' dead time and lag, as
/// the programmed set points do.
class Plant {
 public:
  using Axes = std::array<double, 6>;  ///< deg
  static constexpr std::size_t kMaxDeadTimeCycles = 126;

  /// Throws std::invalid_argument where an option is out of its range.
  explicit Plant(const PlantOptions& options);

  struct Sent {
    std::uint64_t ipoc;
    Axes aspos_deg;  ///< programmed, without correction
    Axes aipos_deg;  ///< where the axes are
    std::optional<std::int64_t> delay;
    std::uint16_t source_port;
  };
  /// @param aspos_deg  what the program commands in this cycle
  /// @return what is sent; nothing in a pause, and after the session's timeout
  std::optional<Sent> begin_cycle(const Axes& aspos_deg);

  /// @return whether it is the answer that this cycle waits for. The first one counts.
  bool take_reply(std::uint64_t ipoc, const Axes& correction_deg);

  struct State {
    bool alive;         ///< false from the timeout until the session is restarted
    Axes in_force_deg;  ///< the correction that the drives are given
    double step_deg;    ///< greatest change of an axis in it by this cycle
  };
  State end_cycle();

  struct Restart {
    int pause_cycles = 0;               ///< without a datagram
    std::optional<std::uint64_t> ipoc;  ///< of the first datagram; else the counter has gone on meanwhile
    std::optional<std::uint16_t> source_port;
    /// The program began with a motion to the actual axes, so that the arm stands at the first set point.
    /// Otherwise the drives continue to what they were last given, less the correction.
    bool arm_settled = true;
  };
  /// RSI is switched off and on, between two cycles: nothing is in effect any more. That is no step of the
  /// arm: the program takes the place where it stands as its set point.
  void restart_session(const Restart& restart);

  bool alive() const { return alive_; }
  const Axes& in_force_deg() const { return in_force_deg_; }

 private:
  static constexpr std::size_t kLine = 128;  // a power of two

  void drive(const Axes& aspos_deg);
  void stand_at(const Axes& axes_deg);
  const Axes& commanded_ago(std::size_t cycles) const;

  PlantOptions options_;
  std::size_t dead_cycles_;  // whole ones
  double dead_part_;         // of one more
  Axes share_{};             // of its distance that an axis covers in a cycle

  std::uint64_t ipoc_;
  std::uint16_t source_port_;
  int pause_cycles_ = 0;
  bool settles_ = true;  // at the next set point
  bool sent_ = false;
  bool alive_ = true;
  std::optional<Axes> reply_;
  std::int64_t unanswered_ = 0;
  std::int64_t unanswered_in_a_row_ = 0;
  Axes in_force_deg_{};
  std::array<Axes, kLine> commanded_deg_{};  // a ring; what the drives were given
  std::size_t newest_ = 0;
  Axes actual_deg_{};
};

}  // namespace truepose::test
