#pragma once

#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/cell/service.hpp"
#include "daemon/store/campaign_plan.hpp"

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
/// Which point it is and what the tracker saw of it, as answers and events have it: {"pose","purpose","smr",
/// "p_mm","std_mm"}, the last two null where it saw nothing; of a 6-D target "abc_deg" (KUKA's angles) and
/// "std_abc_deg", the standard deviation of a rotation about each axis.
boost::json::object seen_json(const StoredPoint& point);
/// A row of campaign.list.
boost::json::object campaign_json(const CampaignRecord& record);
/// The answer of campaign.get, of a campaign that is not under way.
boost::json::object campaign_answer(const StoredCampaign& campaign, const RobotModel& robot,
                                    std::size_t offset, std::size_t limit);
/// The campaign that a report is asked of: this one, or without an id the last calibration. Blocks.
std::expected<CampaignRecord, control::RpcError> report_record(Store& store, const std::string& id);
/// The answer of report.get.
std::expected<boost::json::object, control::RpcError> report_answer(const CampaignRecord& record,
                                                                    std::size_t offset, std::size_t limit);
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
    boost::json::value progress;
  };

  /// @param current  nothing where there was none since the start
  CampaignArchive(const CellParts& parts, std::function<std::optional<Current>()> current)
      : parts_{parts}, current_{std::move(current)} {}

  static std::vector<Method<CampaignArchive>> methods();

 private:
  MethodReply list(boost::json::object params);
  MethodReply get(boost::json::object params);
  MethodReply measurements(boost::json::object params);
  MethodReply report(boost::json::object params);
  MethodReply points(boost::json::object params);
  MethodReply answer_of(std::string id, std::function<MethodResult(const StoredCampaign&)> make);

  CellParts parts_;
  std::function<std::optional<Current>()> current_;
};

}  // namespace truepose::daemon
