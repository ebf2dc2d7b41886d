#pragma once

#include <optional>

#include "drivers/mock/mock_cell.hpp"
#include "drivers/tracker.hpp"

namespace truepose::drivers {

/// A laser tracker in the process that sees the mock cell's reflector.
class MockTracker final : public Tracker {
 public:
  explicit MockTracker(MockCell& cell) : cell_{cell} {}

  boost::asio::awaitable<std::expected<TrackerIdentity, TrackerError>> connect(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, TrackerError>> aim(Eigen::Vector3d p_W_mm,
                                                                double search_radius_mm,
                                                                TimePoint deadline) override;
  boost::asio::awaitable<std::expected<SmrPoint, TrackerError>> measure(TimePoint deadline) override;
  void average_over(Duration time) override { time_ = time; }
  boost::asio::awaitable<std::expected<void, TrackerError>> turn_over(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, TrackerError>> check(TimePoint deadline) override;
  void disconnect() noexcept override { connected_ = false; }

  bool connected() const { return connected_; }
  /// From now on it does not answer for so long.
  void leave(Duration time) {
    connected_ = false;
    gone_until_ = cell_.clock().now() + time;
  }

 private:
  static constexpr Duration kUsualTime = std::chrono::seconds{2};

  boost::asio::awaitable<std::optional<TrackerError>> link_fault(TimePoint deadline);
  /// Of the arm's that can be seen, the one next to where it looks; the first where none can.
  std::size_t nearest_reflector(const Eigen::Vector3d& p_W_mm) const;
  /// The nest next to where it looks, where one is within the radius.
  std::optional<std::size_t> nest_within(double radius_mm, const Eigen::Vector3d& p_W_mm) const;

  MockCell& cell_;
  bool connected_ = false;
  TimePoint gone_until_{};
  bool locked_ = false;
  std::optional<std::size_t> nest_;  ///< that is locked; none: a reflector of the arm
  std::size_t reflector_ = 0;        ///< of the arm, where that is locked
  int face_ = 1;
  Duration time_ = kUsualTime;                 ///< of a measurement
  Eigen::Vector3d locked_offset_mm_{0, 0, 0};  ///< of the reflector that was found from ours
};

}  // namespace truepose::drivers
