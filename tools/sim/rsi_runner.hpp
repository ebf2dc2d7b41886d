#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "tools/sim/rsi_client.hpp"
#include "tools/sim/rsi_statistics.hpp"

namespace truepose::sim {

struct RsiRunnerOptions {
  std::string host;  ///< numeric address of the PC
  std::uint16_t port = 0;
  std::chrono::milliseconds cycle{4};
};

/// One RSI session in real time: a thread of its own that sends a datagram at each absolute tick and takes
/// the answers until the next. SCHED_FIFO where that is allowed.
class RsiRunner {
 public:
  /// Starts the session. Throws boost::system::system_error when there is no socket to be had.
  /// @param ended  called once from the session's thread when RSI ends by itself, not when it is destroyed
  RsiRunner(const RsiRunnerOptions& options, RsiClient client, std::function<void(RsiEnd)> ended);
  ~RsiRunner();

  struct Arm {
    JointVector q;  ///< actual
    bool moving = false;
  };
  Arm arm() const;
  RsiStatistics statistics() const;

  /// Ends the session with the cycle that is under way, which the statistics then contain.
  void stop();

  /// Fault: no datagram gets through, either way, for this long.
  void drop(std::chrono::milliseconds duration);

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

}  // namespace truepose::sim
