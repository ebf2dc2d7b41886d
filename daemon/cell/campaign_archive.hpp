#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/cell/service.hpp"
#include "daemon/store/campaign_plan.hpp"

namespace truepose::daemon {

boost::json::array vector_json(const Eigen::Vector3d& v);

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
  struct Found {
    std::optional<CampaignRecord> record;
    std::vector<StoredPoint> points;
    std::vector<SkippedPose> skipped;
    std::vector<Resumption> resumptions;
  };

  MethodReply list(boost::json::object params);
  MethodReply get(boost::json::object params);
  MethodReply report(boost::json::object params);

  StoreResult<Found> read(const std::string& id);
  boost::json::array points_json(const std::vector<StoredPoint>& points, std::size_t offset,
                                 std::size_t limit) const;

  CellParts parts_;
  std::function<std::optional<Current>()> current_;
};

}  // namespace truepose::daemon
