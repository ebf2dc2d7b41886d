#pragma once

#include <boost/asio/awaitable.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign.hpp"
#include "drivers/mock/mock_cell.hpp"

namespace truepose::test {

/// The method paper's arm as its data sheet has it.
RobotModel kr210();
/// The same with the errors of the paper's Table 2.
RobotModel kr210_with_errors();

/// A cell with that arm, its tracker 4 m away, 16 + 12 poses.
config::CellConfig example_cell();
/// The same cell as it really is: base and reflector are some centimetres off their rough values.
drivers::MockCellOptions example_truth();

/// A journal in memory that can be set to fail.
struct MemoryJournal final : daemon::CampaignJournal {
  boost::asio::awaitable<daemon::StoreResult<std::string>> begin(int total) override;
  boost::asio::awaitable<daemon::StoreResult<void>> know(daemon::Identities identities) override;
  boost::asio::awaitable<daemon::StoreResult<void>> add_planned(std::vector<daemon::PlannedPose> poses,
                                                                int total) override;
  boost::asio::awaitable<daemon::StoreResult<daemon::StoredPoint>> add_point(
      daemon::StoredPoint point) override;
  boost::asio::awaitable<daemon::StoreResult<void>> add_skipped(daemon::SkippedPose skipped) override;
  boost::asio::awaitable<daemon::StoreResult<void>> add_identified(std::string sha256) override;
  boost::asio::awaitable<daemon::StoreResult<void>> add_resumption(daemon::Resumption resumption) override;
  boost::asio::awaitable<daemon::StoreResult<void>> end(std::shared_ptr<const daemon::CampaignResult> result,
                                                        std::optional<daemon::CampaignError> error) override;

  int begun = 0, ended = 0;
  std::vector<daemon::StoredPoint> points;
  std::vector<daemon::SkippedPose> skipped;
  std::shared_ptr<const daemon::CampaignResult> result;
  std::optional<daemon::CampaignError> error;
  std::function<void(const daemon::StoredPoint&)> at_point;  ///< of any purpose, before it is there

  /// What the store would give of the campaign to one that continues.
  std::shared_ptr<const daemon::CampaignPast> past() const;
  std::string serial;  ///< of the arm
  daemon::CampaignPlan plan;
  std::vector<daemon::Resumption> resumptions;
};

/// Records the notifications of a campaign, and calls back at each point.
struct RecordingObserver final : daemon::CampaignObserver {
  void on_progress(const daemon::CampaignProgress& progress) override {
    phases.push_back(progress.phase);
    if (at_phase) at_phase(progress.phase);
  }
  void on_point(const daemon::StoredPoint& point, double deviation_mm,
                const daemon::CampaignProgress& progress) override;
  void on_skipped(const daemon::StoredPoint& wanted, const std::string& reason,
                  const daemon::CampaignProgress& progress) override;
  void on_trouble(const std::string& sentence) override {
    troubles.push_back(sentence);
    if (at_trouble) at_trouble(sentence);
  }
  void on_waiting(daemon::CellDevice device, const std::string& reason) override {
    if (at_waiting) at_waiting(device, reason);
  }
  void on_paused(const std::string& sentence) override {
    pauses.push_back(sentence);
    if (at_pause) at_pause();
  }

  std::vector<daemon::CampaignPhase> phases;
  std::vector<double> deviations_mm;
  std::vector<std::string> troubles, pauses;
  std::function<void(daemon::CampaignPhase)> at_phase;
  std::function<void(const std::string&)> at_trouble;
  std::function<void()> at_pause;
  std::function<void(daemon::CellDevice, const std::string&)> at_waiting;
  daemon::CampaignProgress last;
  std::vector<daemon::StoredPoint> given_up;  ///< points of poses that were skipped
  std::function<void(const daemon::StoredPoint&)> at_point;
};

/// Runs a job in place.
boost::asio::awaitable<void> compute_here(std::function<void()> job);

}  // namespace truepose::test
