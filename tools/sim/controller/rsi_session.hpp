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

struct RsiSessionOptions {
  std::string host;  ///< numeric address of the PC
  std::uint16_t port = 0;
  std::chrono::milliseconds cycle{4};
  std::uint16_t source_port = 0;  ///< that it sends from; 0: another one each time that RSI is switched on
  std::vector<config::ScenarioFault> faults{};  ///< those of RSI, in cycles
  std::uint64_t cycles_before = 0;              ///< last_cycle of earlier sessions: faults count on
};

/// What a session reports while it runs. Called where its cycles run, which may be a thread of its own.
struct RsiListener {
  std::function<void(RsiEnd)> ended;  ///< once, when RSI ends by itself; not when it is destroyed
  /// A name in the PC's replies that a controller ignores without a word.
  std::function<void(const std::string& name)> unknown_name = [](const std::string&) {};
  /// A line on the first reply that was rejected for a cause.
  std::function<void(const std::string& line)> rejected = [](const std::string&) {};
};

/// One RSI session of the simulated controller, whatever runs its cycles.
class RsiSession {
 public:
  virtual ~RsiSession() = default;

  virtual JointVector axes() const = 0;  ///< actual
  virtual RsiStatistics statistics() const = 0;

  /// Ends the session with the cycle that is under way, which the statistics then contain.
  virtual void stop() = 0;

  /// A fault that begins with the next cycle, whatever its `at` says; in cycles.
  virtual void disturb(config::ScenarioFault fault) = 0;
};

/// Throws boost::system::system_error when there is no socket to be had.
using StartRsi = std::function<std::unique_ptr<RsiSession>(const RsiSessionOptions&, RsiClient, RsiListener)>;

}  // namespace truepose::sim
