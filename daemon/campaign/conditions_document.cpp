#include "daemon/campaign/conditions_document.hpp"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "config/cell_setup.hpp"
#include "proto/record/calibration_document.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;

json::object range_json(const std::vector<StoredPoint>& points, double StoredPoint::*quantity) {
  const auto [min, max] = std::ranges::minmax(points, {}, quantity);
  return {{"min", min.*quantity}, {"max", max.*quantity}};
}

std::size_t poses_of(const std::vector<StoredPoint>& points) {
  std::set<int> poses;
  for (const StoredPoint& point : points) {
    if (point.purpose != PointPurpose::Reference) poses.insert(point.pose);
  }
  return poses.size();
}

}  // namespace

json::object conditions_document(const CampaignResult& result, const CampaignRecord& record) {
  const std::vector<StoredPoint>& points = result.points;
  json::object conditions{{"started", record.started},
                          {"ended", record.ended},
                          {"poses_measured", poses_of(points)},
                          {"poses_skipped", result.skipped.size()}};
  if (points.empty() || std::ranges::max(points, {}, &StoredPoint::pressure_mbar).pressure_mbar <= 0)
    return conditions;
  conditions["temperature_c"] = range_json(points, &StoredPoint::temperature_c);
  conditions["pressure_mbar"] = range_json(points, &StoredPoint::pressure_mbar);
  conditions["humidity_percent"] = range_json(points, &StoredPoint::humidity_percent);
  return conditions;
}

json::object options_document(const config::CellConfig& config) {
  constexpr std::array<std::string_view, 3> kCriteria{"D", "A", "I"};
  const config::CampaignConfig& campaign = config.campaign;
  json::object options{
      {"Poses planned", std::to_string(campaign.identify_poses) + " to identify, " +
                            std::to_string(campaign.validate_poses) + " to validate"},
      {"Poses chosen", std::string{kCriteria[static_cast<std::size_t>(campaign.criterion)]} +
                           "-optimal, of " + std::to_string(campaign.candidates) + " candidates"}};
  for (auto& option : record::options_json(config::calibrate_options(config)))
    options[option.key()] = std::move(option.value());
  return options;
}

json::array skipped_document(const CampaignResult& result) {
  json::array list;
  for (const SkippedPose& pose : result.skipped) {
    list.push_back(
        json::object{{"pose", pose.pose + 1}, {"attempts", pose.attempts}, {"reason", pose.reason}});
  }
  return list;
}

}  // namespace truepose::daemon
