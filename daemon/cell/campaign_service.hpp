#pragma once

#include <boost/asio/awaitable.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/campaign_options.hpp"
#include "daemon/cell/campaign_archive.hpp"
#include "daemon/cell/campaign_request.hpp"
#include "proto/rpc/drift.hpp"
#include "proto/rpc/events.hpp"

namespace truepose::daemon {

/// The campaign of a cell: starts one after the other, and informs clients how far it is.
class CampaignService final : private CampaignObserver {
 public:
  CampaignService(const CellParts& parts, CellRunner& runner, StoreWatch& store, DeviceService& devices,
                  ModelService& models);

  static std::vector<Served<CampaignService>> methods();

  /// Takes note of the campaigns that were interrupted.
  boost::asio::awaitable<StoreResult<void>> load_interrupted();
  /// Pauses the campaign that is under way, as an operator would.
  Answer<rpc::CampaignPause> pause_because(const std::string& why, const std::string& by);
  /// Ends the campaign that is under way, where there is one, so that it may continue later.
  void interrupt(const std::string& reason);
  bool running() const { return run_ && !run_->ended; }
  /// The last one, under way or ended.
  std::optional<CampaignArchive::Current> current() const;
  /// How far the campaign is that is under way, as clients see it, and as it says itself.
  std::optional<rpc::CampaignProgress> status() const;
  std::optional<CampaignProgress> progress() const;
  /// Those that may continue, the last begun first.
  std::vector<rpc::InterruptedCampaign> interrupted_campaigns() const;
  /// What may be asked for because of them.
  std::vector<std::string> also_allowed() const;

 private:
  /// One campaign: under way, or the last one.
  struct Run {
    Run(StoreJournal::Options options, const CellParts& parts, CampaignDevices devices,
        CampaignObserver& observer, CampaignOrder order, std::shared_ptr<const CampaignPast> past);
    StoreJournal journal;
    Campaign campaign;
    bool ended = false;

    const std::string& id() const { return journal.record().id; }
  };

  using Progress = std::expected<rpc::CampaignProgress, control::RpcError>;

  Reply<rpc::CampaignStart> start(rpc::CampaignStart asked, std::string by);
  Reply<rpc::DriftCheck> drift_check(rpc::DriftCheck asked, std::string by);
  Reply<rpc::CampaignPause> pause(rpc::CampaignPause, std::string by);
  Reply<rpc::CampaignResume> resume(rpc::CampaignResume request, std::string by);
  Reply<rpc::CampaignAbort> abort(rpc::CampaignAbort request, std::string by);

  Answer<rpc::CampaignStart> begin(CampaignRequest asked, const std::string& by);
  std::expected<void, control::RpcError> launch(StoreJournal::Options options, CampaignOrder order,
                                                const CellEvent& event, const std::string& by,
                                                std::shared_ptr<const CampaignPast> past = {});
  Progress request(const CellEvent& event, const std::string& reason, const std::string& by);

  // Of one that was interrupted.
  struct ResumableCampaign {
    std::shared_ptr<const CampaignPast> past;
    StoreJournal::Options options;
    CampaignOrder order;
  };
  boost::asio::awaitable<std::expected<ResumableCampaign, control::RpcError>> resumable_campaign(
      std::string id);
  /// @param why  it did not continue
  boost::asio::awaitable<void> keep_interrupted(std::string id, std::string why);
  boost::asio::awaitable<StoreResult<void>> keep(CampaignRecord record);
  boost::asio::awaitable<Progress> resume_interrupted(std::string id, std::string by);
  boost::asio::awaitable<Progress> abort_interrupted(std::string id);
  boost::asio::awaitable<std::expected<CampaignOrder, control::RpcError>> order_of(std::string kind,
                                                                                   KeptOrder kept);
  std::expected<BaseOrder, control::RpcError> touching_order(const KeptOrder& kept,
                                                             const ModelService::Found& model) const;
  std::expected<const InterruptedCampaign*, control::RpcError> interrupted(const std::string& id) const;
  control::RpcError nothing_paused() const;
  control::RpcError not_resumable_error(const std::string& id, const std::string& why) const;
  boost::asio::awaitable<void> run(std::shared_ptr<Run> run);
  boost::asio::awaitable<void> close(Run& run, std::optional<CampaignError> error);
  boost::asio::awaitable<void> keep_end();
  /// Of the campaign that is under way, or of the last one.
  rpc::CampaignProgress last_progress() const;
  void publish(const rpc::CampaignProgress& progress);
  void publish(const StoredPoint& point, std::optional<double> error_mm, const std::string& why_not);

  void on_progress(const CampaignProgress& progress) override;
  void on_point(const StoredPoint& point, double deviation_mm, const CampaignProgress& progress) override;
  void on_skipped(const StoredPoint& wanted, const std::string& reason,
                  const CampaignProgress& progress) override;
  void on_trouble(const std::string& sentence) override;
  void on_waiting(CellDevice device, const std::string& reason) override;
  void on_paused(const std::string& sentence) override;
  void on_store_failed(const StoreError& error) override { store_.failed(error); }

  CellParts parts_;
  CellRunner& runner_;
  StoreWatch& store_;
  DeviceService& devices_;
  ModelService& models_;
  CampaignRequests requests_;
  std::shared_ptr<Run> run_;
  bool stopping_ = false;  ///< the daemon ends
  std::vector<InterruptedCampaign> interrupted_;
};

}  // namespace truepose::daemon
