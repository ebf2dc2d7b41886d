#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "tools/sim/alarms.hpp"
#include "tools/sim/machine.hpp"
#include "tools/sim/tracker/one_client_port.hpp"
#include "tools/sim/tracker/tracker_jobs.hpp"
#include "tools/sim/tracker/tracker_server.hpp"

namespace truepose::sim {

/// What is simulated behind a TrackerServer: the beam, what takes it time, and its client, who speaks a
/// protocol of its own. Shared with its coroutines; after close() none of them touches the target any more.
class SimulatedTracker : public std::enable_shared_from_this<SimulatedTracker> {
 public:
  /// Listens at once. Throws boost::system::system_error when the port cannot be bound.
  /// @param target       outlives the server
  /// @param turned_away  that a second client is sent
  SimulatedTracker(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
                   TrackerServerOptions options, std::string turned_away);
  virtual ~SimulatedTracker() = default;

  void close();

  std::uint16_t port() const { return port_->port(); }
  std::uint64_t measurements() const { return measurements_; }
  void disturb(const TrackerDisturbance& disturbance) { beam_.disturb(disturbance); }
  void beam_break(std::chrono::milliseconds duration);
  void restart();

 protected:
  using Job = TrackerJobs::Job;

  virtual void connected() = 0;
  /// @return whether the connection continues
  virtual bool take(std::string_view bytes) = 0;
  /// Tells the client that no reflector is locked any more.
  virtual void lock_is_lost() = 0;
  /// Tells the client that a reflector was locked that it had not asked for.
  virtual void lock_is_found() = 0;
  virtual bool power_lock() const { return options_.power_lock; }
  /// What else it does by itself, every 20 ms of simulated time.
  virtual void look_after() = 0;
  /// What a restart loses of what the client had set.
  virtual void forget() = 0;
  /// Ends what is under way without a word.
  virtual void drop_job();

  /// To the client; not where a silent tracker is simulated.
  void send(std::string bytes);
  void spawn(boost::asio::awaitable<void> job);
  /// Looks whether the beam still reaches what it was locked to.
  void follow();

  const Machine machine_;
  const TrackerServerOptions options_;
  TrackerBeam beam_;
  TrackerJobs jobs_;
  bool initialised_ = false;
  bool measuring_ = false;  ///< what is under way is a measurement
  std::uint64_t measurements_ = 0;
  std::optional<OneClientPort> port_;

 private:
  void lock_by_itself();
  void watch_later();

  Alarms watch_;
};

}  // namespace truepose::sim
