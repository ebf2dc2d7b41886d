#pragma once

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "daemon/campaign/campaign.hpp"
#include "drivers/mock/mock_robot.hpp"
#include "drivers/mock/mock_tracker.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "tests/daemon/example_cell.hpp"

namespace truepose::daemon {

/// Campaigns of the example cell over the mock drivers, in virtual time.
struct CampaignTest : testing::Test {
  using Outcome = std::expected<std::shared_ptr<const CampaignResult>, CampaignError>;

  CampaignTest() { truth.seed = 5; }

  /// Begins a campaign in a cell like `truth`, after whatever campaign was before.
  /// @param past  of one that was interrupted and continues
  void start(CampaignOrder order = CalibrationOrder{}, std::shared_ptr<const CampaignPast> past = {}) {
    outcome.reset();
    journal = {};
    campaign.reset();
    tracker.reset();
    robot.reset();
    cell.emplace(truth, clock);
    robot.emplace(*cell);
    tracker.emplace(*cell);
    campaign.emplace(config, CampaignDevices{*robot, *tracker, clock}, journal, observer, &test::compute_here,
                     std::move(order), std::move(past));
    boost::asio::co_spawn(io, campaign->run(), [this](std::exception_ptr failed, Outcome ended) {
      ASSERT_FALSE(failed);
      outcome.emplace(std::move(ended));
    });
  }
  /// Runs the campaign as far as it goes by itself. @return whether it ended
  bool go_on() {
    return clock.run(io, [this] { return outcome.has_value(); });
  }
  void at(Duration since_start, std::function<void()> action) {
    boost::asio::co_spawn(io, clock.sleep_until(TimePoint{} + since_start),
                          [action](std::exception_ptr) { action(); });
  }

  config::CellConfig config = test::example_cell();
  drivers::MockCellOptions truth = test::example_truth();
  boost::asio::io_context io;
  drivers::VirtualClock clock;
  std::optional<drivers::MockCell> cell;
  std::optional<drivers::MockRobot> robot;
  std::optional<drivers::MockTracker> tracker;
  test::MemoryJournal journal;
  test::RecordingObserver observer;
  std::optional<Campaign> campaign;
  std::optional<Outcome> outcome;
};

}  // namespace truepose::daemon
