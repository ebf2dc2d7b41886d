#include "drivers/mock/mock_tracker.hpp"

#include <algorithm>

namespace truepose::drivers {

namespace asio = boost::asio;
using namespace std::chrono_literals;

asio::awaitable<std::expected<TrackerIdentity, TrackerError>> MockTracker::connect(TimePoint deadline) {
  Clock& clock = cell_.clock();
  connected_ = false;
  locked_ = false;
  if (clock.now() < gone_until_) {
    co_return std::unexpected(TrackerError{TrackerFault::Unreachable, "the tracker does not answer"});
  }
  co_await clock.sleep_until(std::min(deadline, clock.now() + 20s));
  connected_ = true;
  co_return TrackerIdentity{"MockTracker", "MOCK-0002", "1.0"};
}

asio::awaitable<std::expected<void, TrackerError>> MockTracker::aim(Eigen::Vector3d p_W_mm,
                                                                    double search_radius_mm,
                                                                    TimePoint deadline) {
  Clock& clock = cell_.clock();
  const MockFaults& faults = cell_.options().faults;
  locked_ = false;
  auto fault = co_await link_fault(deadline);
  if (fault) co_return std::unexpected(*fault);
  const double distance_mm = (cell_.p_WS_mm() - p_W_mm).norm();
  co_await clock.sleep_until(
      std::min(deadline, clock.now() + 1s + std::chrono::milliseconds{static_cast<int>(20 * distance_mm)}));
  const bool other = search_radius_mm > 100 && cell_.happens(faults.wrong_reflector);
  const bool missed = cell_.happens(faults.no_target);
  if (!other && (missed || distance_mm > search_radius_mm || !cell_.visible())) {
    co_return std::unexpected(
        TrackerError{TrackerFault::NoTarget, "no reflector found where the tracker looked"});
  }
  locked_offset_mm_.setZero();
  if (other) locked_offset_mm_ = Eigen::Vector3d{cell_.uniform(60, 100), 0, 0};
  locked_ = true;
  co_return std::expected<void, TrackerError>{};
}

asio::awaitable<std::expected<SmrPoint, TrackerError>> MockTracker::measure(TimePoint deadline) {
  Clock& clock = cell_.clock();
  auto fault = co_await link_fault(deadline);
  if (fault) co_return std::unexpected(*fault);
  if (!locked_) co_return std::unexpected(TrackerError{TrackerFault::NoTarget, "no reflector is locked"});
  co_await clock.sleep_until(std::min(deadline, clock.now() + 2s));
  if (cell_.moving() || cell_.happens(cell_.options().faults.beam_broken)) {
    locked_ = false;
    co_return std::unexpected(
        TrackerError{TrackerFault::BeamBroken, "the beam was broken during the measurement"});
  }
  const double scatters = cell_.options().faults.scattering;
  const bool scattering = scatters > 0 && cell_.happens(scatters);
  const TrackerNoiseModel noise =
      scattering ? TrackerNoiseModel{.range_mm = 3, .transverse_mm = 3} : cell_.options().noise;
  SmrPoint point;
  point.p_WS_mm = cell_.reading_mm(noise) + locked_offset_mm_;
  point.std_mm.setConstant(noise.range_mm);
  point.temperature_c = 20;
  point.pressure_mbar = 1013;
  point.humidity_percent = 50;
  co_return point;
}

asio::awaitable<std::expected<void, TrackerError>> MockTracker::check(TimePoint) {
  if (!connected_) co_return std::unexpected(TrackerError{TrackerFault::Disconnected, "not connected"});
  co_return std::expected<void, TrackerError>{};
}

asio::awaitable<std::optional<TrackerError>> MockTracker::link_fault(TimePoint deadline) {
  Clock& clock = cell_.clock();
  const MockFaults& faults = cell_.options().faults;
  if (!connected_) co_return TrackerError{TrackerFault::Disconnected, "not connected"};
  co_await clock.sleep_until(std::min(deadline, clock.now() + 5ms));
  if (cell_.happens(faults.tracker_busy)) co_return TrackerError{TrackerFault::Busy, "the tracker is busy"};
  if (cell_.happens(faults.tracker_lost)) {
    co_return lose(TrackerFault::Disconnected, "the connection to the tracker was lost");
  }
  if (cell_.happens(faults.tracker_restart)) {
    gone_until_ = clock.now() + cell_.outage();
    co_return lose(TrackerFault::Disconnected, "the tracker restarted");
  }
  if (cell_.happens(faults.tracker_silent)) {
    co_await clock.sleep_until(deadline);
    co_return lose(TrackerFault::Timeout, "the tracker did not answer");
  }
  co_return std::nullopt;
}

TrackerError MockTracker::lose(TrackerFault fault, const char* detail) {
  connected_ = false;
  locked_ = false;
  return {fault, detail};
}

}  // namespace truepose::drivers
