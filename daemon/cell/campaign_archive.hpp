#pragma once

#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/cell/service.hpp"
#include "daemon/store/campaign_plan.hpp"
#include "proto/rpc/campaign.hpp"
#include "proto/rpc/report.hpp"

namespace truepose::daemon {

// What a store says of its campaigns, in the words of the control protocol: by the daemon, and by a program
// that reads its file without one.

struct StoredCampaign {
  CampaignRecord record;
  std::vector<StoredPoint> points;
  std::vector<SkippedPose> skipped;
  std::vector<Resumption> resumptions;  ///< of the campaign that measured the points
};

/// @param id  empty: the last one
/// @return nothing where there is none
StoreResult<std::optional<StoredCampaign>> read_campaign(Store& store, const std::string& id);
rpc::SeenPoint seen_point(const StoredPoint& point);
rpc::CampaignSummary campaign_summary(const CampaignRecord& record);
/// The answer of campaign.get, of a campaign that is not under way.
rpc::CampaignGet::Result campaign_answer(const StoredCampaign& campaign, const RobotModel& robot,
                                         std::size_t offset, std::size_t limit);
/// The campaign that a report is asked of: this one, or without an id the last calibration. Blocks.
std::expected<CampaignRecord, control::RpcError> report_record(Store& store, const std::string& id);
/// The answer of report.get.
Answer<rpc::ReportGet> report_answer(const CampaignRecord& record, std::size_t offset, std::size_t limit);
/// The points to identify and to validate from, as they were measured: a measurement file; of a campaign that
/// measures a tool the readings of its points, as `truepose tool` reads them. Where the campaign was
/// interrupted, all as the tracker would have seen them from where it stood at first.
std::string measurements_csv(const StoredCampaign& campaign, const RobotModel& robot);

/// The campaigns that the store has, with the one that is under way.
class CampaignArchive {
 public:
  /// The campaign of now, which is not in the store before its devices are known.
  struct Current {
    bool running = false;
    CampaignRecord record;
    rpc::CampaignProgress progress;
  };

  /// @param current  nothing where there was none since the start
  CampaignArchive(const CellParts& parts, std::function<std::optional<Current>()> current)
      : parts_{parts}, current_{std::move(current)} {}

  static std::vector<Served<CampaignArchive>> methods();

 private:
  Reply<rpc::CampaignList> list(rpc::CampaignList request);
  Reply<rpc::CampaignGet> get(rpc::CampaignGet request);
  Reply<rpc::CampaignExport> measurements(rpc::CampaignExport request);
  Reply<rpc::ReportGet> report(rpc::ReportGet request);
  Reply<rpc::CampaignPoints> points(rpc::CampaignPoints request);
  template <rpc::Request R>
  Reply<R> answer_of(std::string id, std::function<Answer<R>(const StoredCampaign&)> make);

  CellParts parts_;
  std::function<std::optional<Current>()> current_;
};

}  // namespace truepose::daemon
