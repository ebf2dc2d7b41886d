#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/scenario.hpp"
#include "tools/sim/controller/rsi_client.hpp"
#include "tools/sim/controller/rsi_statistics.hpp"

namespace truepose::sim {

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
