#include "drivers/timed_tracker.hpp"

#include <optional>
#include <string>
#include <utility>

#include "drivers/deadline.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;

TrackerError late(std::string_view what) {
  return {TrackerFault::Timeout, "the tracker " + std::string{what} + " before the deadline"};
}

asio::awaitable<std::expected<TrackerIdentity, TrackerError>> TimedTracker::connect(TimePoint deadline) {
  auto connecting = dialogue_->connect();
  auto identity = co_await before(clock_, deadline, std::move(connecting));
  const bool connected = identity && *identity;
  if (!connected) dialogue_->close();
  if (!identity) co_return std::unexpected(late("was not connected and ready"));
  co_return *std::move(identity);
}

asio::awaitable<std::expected<TrackerIdentity, TrackerError>> TimedTracker::inspect(TimePoint deadline) {
  auto inspecting = dialogue_->inspect();
  auto identity = co_await before(clock_, deadline, std::move(inspecting));
  dialogue_->close();
  if (!identity) co_return std::unexpected(late("did not answer"));
  co_return *std::move(identity);
}

asio::awaitable<std::expected<void, TrackerError>> TimedTracker::aim(Eigen::Vector3d p_W_mm,
                                                                     double search_radius_mm,
                                                                     TimePoint deadline) {
  auto aiming = dialogue_->aim(p_W_mm, search_radius_mm);
  const auto aimed = co_await before(clock_, deadline, std::move(aiming));
  if (!aimed) co_return std::unexpected(late("found no reflector"));
  co_return *aimed;
}

asio::awaitable<std::expected<SmrPoint, TrackerError>> TimedTracker::measure(TimePoint deadline) {
  auto measuring = dialogue_->measure();
  const auto point = co_await before(clock_, deadline, std::move(measuring));
  if (!point) co_return std::unexpected(late("gave no measurement"));
  co_return *point;
}

asio::awaitable<std::expected<void, TrackerError>> TimedTracker::turn_over(TimePoint deadline) {
  auto turning = dialogue_->turn_over();
  const auto turned = co_await before(clock_, deadline, std::move(turning));
  if (!turned) co_return std::unexpected(late("did not come to the reflector from its other face"));
  co_return *turned;
}

asio::awaitable<std::expected<void, TrackerError>> TimedTracker::check(TimePoint deadline) {
  auto checking = dialogue_->check();
  const auto checked = co_await before(clock_, deadline, std::move(checking));
  if (!checked) co_return std::unexpected(late("did not say how it is"));
  co_return *checked;
}

}  // namespace truepose::drivers
