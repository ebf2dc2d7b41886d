#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/scenario.hpp"
#include "tools/sim/controller/rsi_client.hpp"

namespace truepose::sim {

/// Times from a datagram to its answer, counted by the microsecond.
class TurnaroundHistogram {
 public:
  void record(std::chrono::nanoseconds turnaround);
  void add(const TurnaroundHistogram& other);

  /// The smallest time, in whole microseconds rounded up, that this share of the answers did not exceed; 0
  /// without any.
  std::int64_t percentile_us(double share) const;
  std::int64_t max_us() const { return max_us_; }

  /// How many answers took so many whole microseconds, rounded up; those that none took left out. The
  /// difference of two such lists is that of the time between them.
  std::vector<std::pair<std::int64_t, std::uint32_t>> counts() const;

 private:
  // Slower answers share the last bin; max_us() knows the slowest.
  static constexpr std::size_t kBins = 50'000;

  std::vector<std::uint32_t> bins_ = std::vector<std::uint32_t>(kBins);
  std::uint64_t count_ = 0;
  std::int64_t max_us_ = 0;
};

/// Replies to other controllers that send to the same PC.
struct SecondSenders {
  std::uint64_t cycles = 0;
  std::uint64_t answered = 0;
  double max_step_rad = 0;  ///< of a correction that they had in effect

  void add(const RsiCounters& counters);
  void add(const SecondSenders& other);
};

/// What the RSI sessions of a simulator's life came to.
struct RsiStatistics {
  RsiCounters counters;
  SecondSenders second_senders;
  TurnaroundHistogram turnaround;
  double correction_in_effect_rad = 0;  ///< greatest of an axis; 0 while RSI is off
  std::uint64_t sessions = 0;
  std::uint64_t timeouts = 0;  ///< sessions that ended with KSS29002
  std::uint64_t overruns = 0;  ///< ticks that the simulator itself missed
  std::chrono::nanoseconds longest_overrun{0};
  std::uint64_t last_cycle = 0;  ///< of the simulator's life, whose faults have begun

  void add(const RsiStatistics& other);
};

struct RsiRunnerOptions {
  std::string host;  ///< numeric address of the PC
  std::uint16_t port = 0;
  std::chrono::milliseconds cycle{4};
  std::uint16_t source_port = 0;  ///< that it sends from; 0: another one each time that RSI is switched on
  std::vector<config::ScenarioFault> faults{};  ///< those of RSI, in cycles
  std::uint64_t cycles_before = 0;              ///< last_cycle of earlier sessions: faults count on
};

/// What a session tells while it runs. Called from its own thread.
struct RsiListener {
  std::function<void(RsiEnd)> ended;  ///< once, when RSI ends by itself; not when it is destroyed
  /// A name in the PC's replies that a controller ignores without a word.
  std::function<void(const std::string& name)> unknown_name = [](const std::string&) {};
  /// A line on the first reply that was rejected for a cause.
  std::function<void(const std::string& line)> rejected = [](const std::string&) {};
};

/// One RSI session in real time: a thread of its own that sends a datagram at each absolute tick and takes
/// the answers until the next. SCHED_FIFO where that is allowed.
class RsiRunner {
 public:
  /// Starts the session. Throws boost::system::system_error when there is no socket to be had.
  RsiRunner(const RsiRunnerOptions& options, RsiClient client, RsiListener listener);
  ~RsiRunner();

  struct Arm {
    JointVector q;  ///< actual
    bool moving = false;
  };
  Arm arm() const;
  RsiStatistics statistics() const;

  /// Ends the session with the cycle that is under way, which the statistics then contain.
  void stop();

  /// A fault that begins with the next cycle, whatever its `at` says; in cycles.
  void disturb(config::ScenarioFault fault);

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

}  // namespace truepose::sim
