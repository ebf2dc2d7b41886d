#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/cell_config.hpp"
#include "config/model_file.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/point_clock.hpp"
#include "daemon/store/store.hpp"
#include "daemon/threads/worker.hpp"

namespace truepose::daemon {

/// Keeps one campaign in the cell's store, by way of the store's thread, and makes its model and its document
/// at the end.
class StoreJournal final : public CampaignJournal {
 public:
  struct Options {
    std::string campaign_id;    ///< UUID
    std::string order{};        ///< as order_text(): what it is to do, so that it may continue
    std::string model_id;       ///< UUID of the model, should one come of it
    config::CellConfig config;  ///< the campaign's
    std::string_view kind = kCampaignKinds.front();
    bool activate = true;      ///< the model, if it beats the nominal arm on the validation poses
                               ///< and nothing contradicts it
    std::string started_by{};  ///< the name of who did
    std::string note{};        ///< his words for it
    /// The source of points that are identified again; none: they are measured.
    std::optional<CampaignRecord> source{};
    std::optional<std::vector<int>> validate{};   ///< of that: the poses that validate; none: as measured
    std::optional<CampaignRecord> interrupted{};  ///< that continues; none: one begins
    std::string measured_before{};  ///< when the last point of that was (RFC 3339); empty: it had none
  };

  /// @param store_thread  the only one that touches `store`
  StoreJournal(Options options, Store& store, Worker& store_thread, drivers::WallClock wall_clock,
               const drivers::Clock& steady_clock);

  boost::asio::awaitable<StoreResult<std::string>> begin(int total) override;
  boost::asio::awaitable<StoreResult<void>> know(Identities identities) override;
  boost::asio::awaitable<StoreResult<void>> add_planned(std::vector<PlannedPose> poses, int total) override;
  boost::asio::awaitable<StoreResult<StoredPoint>> add_point(StoredPoint point) override;
  boost::asio::awaitable<StoreResult<void>> add_skipped(SkippedPose skipped) override;
  boost::asio::awaitable<StoreResult<void>> add_identified(std::string sha256) override;
  boost::asio::awaitable<StoreResult<void>> add_resumption(Resumption resumption) override;
  boost::asio::awaitable<StoreResult<void>> end(std::shared_ptr<const CampaignResult> result,
                                                std::optional<CampaignError> error) override;

  /// Writes the end once more that the store could not take.
  boost::asio::awaitable<StoreResult<void>> end_again();
  /// The end is in the store.
  bool ended() const { return ended_; }
  /// The store knows of it.
  bool begun() const { return begun_; }
  const CampaignRecord& record() const { return record_; }
  bool activated() const { return activated_; }

 private:
  config::ModelFile calibrated_model(const CampaignResult& result) const;
  /// @param file  the model that came of the campaign
  ModelRecord model_of(const CampaignResult& result, const config::ModelFile& file, bool active) const;

  Options options_;
  Store& store_;
  Worker& store_thread_;
  drivers::WallClock wall_clock_;
  PointClock point_clock_;
  CampaignRecord record_;
  std::optional<ModelRecord> model_;  ///< that it came to, from its end on
  bool begun_ = false;                ///< the store knows the campaign
  bool ended_ = false, activated_ = false;
};

}  // namespace truepose::daemon
