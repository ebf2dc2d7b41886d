#include "tools/sim/tracker/simulated_tracker.hpp"

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <limits>
#include <utility>

#include "drivers/net/spawn.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using namespace std::chrono_literals;

SimulatedTracker::SimulatedTracker(const asio::any_io_executor& executor, const SimulatedTarget& target,
                                   TrackerNoise noise, TrackerServerOptions options, std::string turned_away)
    : options_{std::move(options)},
      beam_{target, std::move(noise), options_.instrument, options_.speedup},
      jobs_{executor, options_.speedup},
      port_{std::in_place,
            executor,
            options_.address,
            options_.port,
            std::move(turned_away),
            PortListener{[this] { connected(); }, [this](std::string_view bytes) { return take(bytes); },
                         [this] { drop_job(); }}},
      executor_{executor},
      watch_timer_{executor} {}

void SimulatedTracker::close() {
  closed_ = true;
  drop_job();
  port_.reset();
  watch_timer_.cancel();
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

void SimulatedTracker::spawn(asio::awaitable<void> job) { net::spawn(executor_, std::move(job)); }

void SimulatedTracker::follow() {
  if (beam_.follow()) lock_is_lost();
}

/// PowerLock finds a reflector by itself, wherever the beam points.
void SimulatedTracker::lock_by_itself() {
  if (beam_.locked() || jobs_.busy() || !initialised_ || !power_lock()) return;
  if (beam_.lock_within(std::numeric_limits<double>::infinity())) lock_is_found();
}

asio::awaitable<void> SimulatedTracker::watch(std::shared_ptr<SimulatedTracker> self) {
  const auto period = std::clamp<TrackerJobs::Duration>(self->jobs_.scaled(20ms), 1ms, 20ms);
  for (;;) {
    self->watch_timer_.expires_after(period);
    co_await self->watch_timer_.async_wait(asio::as_tuple(asio::use_awaitable));
    if (self->closed_) co_return;
    self->follow();
    self->lock_by_itself();
    self->look_after();
  }
}

// ---- TrackerServer ----

TrackerServer::TrackerServer(std::shared_ptr<SimulatedTracker> tracker) : tracker_{std::move(tracker)} {
  tracker_->start();
}

TrackerServer::~TrackerServer() { tracker_->close(); }

std::uint16_t TrackerServer::port() const { return tracker_->port(); }
std::uint64_t TrackerServer::measurements() const { return tracker_->measurements(); }
void TrackerServer::disturb(const TrackerDisturbance& disturbance) { tracker_->disturb(disturbance); }
void TrackerServer::beam_break(std::chrono::milliseconds duration) { tracker_->beam_break(duration); }
void TrackerServer::restart() { tracker_->restart(); }

}  // namespace truepose::sim
