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
  face_ = 1;
  auto fault = co_await link_fault(deadline);
  if (fault) co_return std::unexpected(*fault);
  const std::size_t reflector = nearest_reflector(p_W_mm);
  const double arms_mm = (cell_.p_WS_mm(reflector) - p_W_mm).norm();
  const auto nest = nest_within(std::min(search_radius_mm, arms_mm), p_W_mm);
  const double distance_mm = nest ? (cell_.nest_mm(*nest) - p_W_mm).norm() : arms_mm;
  co_await clock.sleep_until(
      std::min(deadline, clock.now() + 1s + std::chrono::milliseconds{static_cast<int>(20 * distance_mm)}));
  const bool other = search_radius_mm > 100 && cell_.happens(faults.wrong_reflector);
  const bool missed = cell_.happens(faults.no_target);
  if (!other && (missed || distance_mm > search_radius_mm || !(nest || cell_.visible(reflector)))) {
    co_return std::unexpected(
        TrackerError{TrackerFault::NoTarget, "no reflector found where the tracker looked"});
  }
  nest_ = nest;
  reflector_ = reflector;
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
  co_await clock.sleep_until(std::min(deadline, clock.now() + time_));
  if ((cell_.moving() && !nest_) || cell_.happens(cell_.options().faults.beam_broken)) {
    locked_ = false;
    co_return std::unexpected(
        TrackerError{TrackerFault::BeamBroken, "the beam was broken during the measurement"});
  }
  const double scatters = cell_.options().faults.scattering;
  const bool scattering = scatters > 0 && cell_.happens(scatters);
  const TrackerNoiseModel noise =
      scattering ? TrackerNoiseModel{.range_mm = 3, .transverse_mm = 3} : cell_.options().noise;
  SmrPoint point;
  const Eigen::Vector3d p_mm = nest_ ? cell_.nest_mm(*nest_) : cell_.p_WS_mm(reflector_);
  point.p_WS_mm = cell_.reading_mm(p_mm, face_, noise) + locked_offset_mm_;
  point.std_mm.setConstant(noise.range_mm);
  if (!nest_ && reflector_ == 0) point.orientation = cell_.orientation();
  point.temperature_c = 20;
  point.pressure_mbar = 1013;
  point.humidity_percent = 50;
  co_return point;
}

asio::awaitable<std::expected<void, TrackerError>> MockTracker::turn_over(TimePoint deadline) {
  auto fault = co_await link_fault(deadline);
  if (fault) co_return std::unexpected(*fault);
  if (!locked_) co_return std::unexpected(TrackerError{TrackerFault::NoTarget, "no reflector is locked"});
  co_await cell_.clock().sleep_until(std::min(deadline, cell_.clock().now() + 3s));
  face_ = 3 - face_;
  co_return std::expected<void, TrackerError>{};
}

std::size_t MockTracker::nearest_reflector(const Eigen::Vector3d& p_W_mm) const {
  std::size_t nearest = 0;
  const auto off_mm = [&](std::size_t k) { return (cell_.p_WS_mm(k) - p_W_mm).norm(); };
  for (std::size_t k = 1; k < cell_.reflectors(); ++k) {
    const bool nearer = off_mm(k) < off_mm(nearest);
    if (cell_.visible(k) && (nearer || !cell_.visible(nearest))) nearest = k;
  }
  return nearest;
}

std::optional<std::size_t> MockTracker::nest_within(double radius_mm, const Eigen::Vector3d& p_W_mm) const {
  std::optional<std::size_t> nearest;
  for (std::size_t nest = 0; nest < cell_.options().instrument.nests_mm.size(); ++nest) {
    const double distance_mm = (cell_.nest_mm(nest) - p_W_mm).norm();
    if (distance_mm > radius_mm) continue;
    radius_mm = distance_mm;
    nearest = nest;
  }
  return nearest;
}

asio::awaitable<std::expected<void, TrackerError>> MockTracker::check(TimePoint) {
  if (!connected_) co_return std::unexpected(TrackerError{TrackerFault::Disconnected, "not connected"});
  co_return std::expected<void, TrackerError>{};
}

asio::awaitable<std::optional<TrackerError>> MockTracker::link_fault(TimePoint deadline) {
  Clock& clock = cell_.clock();
  if (!connected_) co_return TrackerError{TrackerFault::Disconnected, "not connected"};
  co_await clock.sleep_until(std::min(deadline, clock.now() + 5ms));
  if (cell_.happens(cell_.options().faults.tracker_busy))
    co_return TrackerError{TrackerFault::Busy, "the tracker is busy"};
  co_return std::nullopt;
}

}  // namespace truepose::drivers
