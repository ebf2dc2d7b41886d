#include "tools/sim/tracker/simulated_tracker.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "drivers/net/spawn.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using namespace std::chrono_literals;

SimulatedTracker::SimulatedTracker(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
                                   TrackerServerOptions options, std::string turned_away)
    : machine_{machine},
      options_{std::move(options)},
      beam_{machine.clock, target, std::move(noise), options_.instrument, options_.speedup},
      jobs_{machine.clock, options_.speedup},
      port_{std::in_place,
            machine,
            options_.address,
            options_.port,
            std::move(turned_away),
            PortListener{[this] { connected(); }, [this](std::string_view bytes) { return take(bytes); },
                         [this] { drop_job(); }}},
      watch_{machine.io, machine.clock} {
  watch_later();
}

void SimulatedTracker::close() {
  drop_job();
  port_.reset();
  watch_.clear();
}

void SimulatedTracker::beam_break(std::chrono::milliseconds duration) {
  beam_.block(duration);
  follow();
}

void SimulatedTracker::restart() {
  drop_job();
  port_->drop();
  beam_.release();
  initialised_ = false;
  forget();
}

void SimulatedTracker::drop_job() {
  measuring_ = false;
  jobs_.drop();
}

void SimulatedTracker::send(std::string bytes) {
  if (!beam_.disturbance().silent) port_->send(std::move(bytes));
}

void SimulatedTracker::spawn(asio::awaitable<void> job) { net::spawn(machine_.io, std::move(job)); }

void SimulatedTracker::follow() {
  if (beam_.follow()) lock_is_lost();
}

/// PowerLock finds a reflector by itself, wherever the beam points.
void SimulatedTracker::lock_by_itself() {
  if (beam_.locked() || jobs_.busy() || !initialised_ || !power_lock()) return;
  if (beam_.lock_within(std::numeric_limits<double>::infinity())) lock_is_found();
}

void SimulatedTracker::watch_later() {
  const auto period = std::clamp<TrackerJobs::Duration>(jobs_.scaled(20ms), 1ms, 20ms);
  watch_.at(machine_.clock.now() + period, [this] {
    follow();
    lock_by_itself();
    look_after();
    watch_later();
  });
}

// ---- TrackerServer ----

TrackerServer::TrackerServer(std::shared_ptr<SimulatedTracker> tracker) : tracker_{std::move(tracker)} {}

TrackerServer::~TrackerServer() { tracker_->close(); }

std::uint16_t TrackerServer::port() const { return tracker_->port(); }
std::uint64_t TrackerServer::measurements() const { return tracker_->measurements(); }
void TrackerServer::disturb(const TrackerDisturbance& disturbance) { tracker_->disturb(disturbance); }
void TrackerServer::beam_break(std::chrono::milliseconds duration) { tracker_->beam_break(duration); }
void TrackerServer::restart() { tracker_->restart(); }

}  // namespace truepose::sim
