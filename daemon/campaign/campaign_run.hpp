#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign_pause.hpp"
#include "daemon/campaign/corrected_points.hpp"
#include "daemon/threads/worker.hpp"

namespace truepose::daemon {

/// What all parts of a campaign share: the cell, who watches, what was measured so far, how far it is, its
/// pauses, and work for which the PC may have no room.
class CampaignRun {
 public:
  /// What is referred to outlives it.
  /// @param past  of a campaign that was interrupted; null: it begins
  CampaignRun(const config::CellConfig& config, drivers::Clock& clock, CampaignJournal& journal,
              CampaignObserver& observer, RunJob run_compute, std::shared_ptr<const CampaignPast> past)
      : config_{config},
        clock_{clock},
        journal_{journal},
        observer_{observer},
        run_compute_{std::move(run_compute)},
        progress_{clock, observer, std::move(past)} {}

  const config::CellConfig& config() const { return config_; }
  drivers::Clock& clock() const { return clock_; }
  CampaignObserver& observer() const { return observer_; }
  ProgressCounter& progress() { return progress_; }
  const ProgressCounter& progress() const { return progress_; }
  CampaignPause& pause() { return pause_; }

  CampaignResult& result() { return *result_; }
  std::shared_ptr<const CampaignResult> shared_result() const { return result_; }
  /// What there is so far to identify and to validate from.
  MeasurementData data() const { return campaign_data(result_->points, config_, result_->resumptions); }
  /// All points so far, with what nests and faces show.
  CorrectedPoints corrected() const {
    return corrected_points(result_->points, config_, result_->resumptions);
  }
  /// Pose of the frame in which the tracker stood when the campaign began in the one of now.
  Eigen::Isometry3d X_now_first() const {
    const std::vector<Resumption>& resumptions = result_->resumptions;
    return resumptions.empty() ? Eigen::Isometry3d::Identity() : resumptions.back().X_first_now.inverse();
  }
  /// The point as the tracker would have seen it when the campaign began.
  StoredPoint in_first_frame(const StoredPoint& point) const {
    return daemon::in_first_frame(point, result_->resumptions);
  }

  /// What the job returns, which may take long. Where there is no memory for it the campaign pauses, and the
  /// job is done once more after a resume.
  template <typename Job>
  boost::asio::awaitable<std::invoke_result_t<Job>> compute(Job job);
  /// Writes until the journal has it. Where there is no room, or the disk fails, the campaign pauses, and
  /// what is to be written waits until the operator has removed the cause and resumes it.
  /// @param add  by which the journal takes it
  template <typename T, typename... What>
  CampaignOutcome<T> write(boost::asio::awaitable<StoreResult<T>> (CampaignJournal::*add)(What...),
                           std::type_identity_t<What>... what);
  /// Whether it is paused for want of room in the store.
  bool waits_for_room() const { return waits_for_room_; }

 private:
  const config::CellConfig& config_;
  drivers::Clock& clock_;
  CampaignJournal& journal_;
  CampaignObserver& observer_;
  RunJob run_compute_;
  std::shared_ptr<CampaignResult> result_ = std::make_shared<CampaignResult>();
  ProgressCounter progress_;
  CampaignPause pause_{observer_, progress_};
  bool waits_for_room_ = false;
};

template <typename Job>
boost::asio::awaitable<std::invoke_result_t<Job>> CampaignRun::compute(Job job) {
  for (;;) {
    try {
      auto result = co_await result_of(run_compute_, job);
      co_return result;
    } catch (const std::bad_alloc&) {
    }
    co_await pause_.wait_for_operator(
        "paused: the PC has no memory for what is to be computed; end other programs, then resume the campaign");
  }
}

template <typename T, typename... What>
CampaignOutcome<T> CampaignRun::write(boost::asio::awaitable<StoreResult<T>> (CampaignJournal::*add)(What...),
                                      std::type_identity_t<What>... what) {
  for (;;) {
    auto written = co_await (journal_.*add)(what...);
    if (written) {
      if constexpr (std::is_void_v<T>)
        co_return Done{};
      else
        co_return *std::move(written);
    }
    const StoreError error = written.error();
    observer_.on_store_failed(error);
    if (!error.may_pass) co_return std::unexpected(store_failed(error));
    waits_for_room_ = true;
    co_await pause_.wait_for_operator("paused, with the last point in memory: " + error.detail +
                                      "; then acknowledge, and resume the campaign");
    waits_for_room_ = false;
  }
}

}  // namespace truepose::daemon
