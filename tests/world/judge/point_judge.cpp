#include "tests/world/judge/point_judge.hpp"

#include <algorithm>
#include <array>
#include <boost/json/serialize.hpp>
#include <cmath>
#include <utility>

#include "tests/world/answers.hpp"
#include "tests/world/judge/truth_judge.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

namespace {

/// The same of its event and of its record in the store.
std::string point_text(const json::object& point) {
  return text_at(point, "purpose") + ' ' + json::serialize(point.at("pose")) + ' ' + text_at(point, "smr") +
         ' ' + json::serialize(point.at("p_mm"));
}

/// Of a pose that a campaign comes to once.
bool is_single(const json::object& point) {
  constexpr std::array kSingle{"identify", "validate", "remeasure"};
  return std::ranges::find(kSingle, text_at(point, "purpose")) != kSingle.end();
}

}  // namespace

void PointJudge::take(const json::object& measurement, bool late) {
  if (!text_at(measurement, "reason").empty()) return;  // its pose was skipped
  ++points;
  const std::string id = text_at(measurement, "campaign_id"), point = point_text(measurement);
  const auto [campaign, is_new] = campaigns_.try_emplace(id);
  if (is_new) campaign->second.tracker_moved_mm = cell_.tracker_moved_mm;
  if (!campaign->second.reported.insert(point).second)
    log_.broken("campaign " + id + " reports a point twice: " + point);
  const bool was_touched = measurement.at("p_mm").is_null();
  if (!late && !was_touched) compare_with_truth(id, measurement);
}

void PointJudge::take_progress(const json::object& progress) {
  std::int64_t& last = done_[text_at(progress, "id")];
  const auto done = progress.at("done").to_number<std::int64_t>();
  if (done < last)
    log_.broken("of " + std::to_string(last) + " poses of a campaign " + std::to_string(done) +
                " are left: " + json::serialize(progress));
  last = done;
}

void PointJudge::compare_with_truth(const std::string& campaign, const json::object& measurement) {
  constexpr double kSigmas = 6;
  // By a resumption points are brought to where the tracker stood at first, as well as a few poses show.
  constexpr double kResumption_mm = 0.3;
  if (log_.had_fault({"tracker-biased", "tracker-scattering", "other-reflector", "tracker-bumped"}, 2min))
    return;
  const json::array& p = measurement.at("p_mm").as_array();
  const Eigen::Vector3d p_mm{p[0].to_number<double>(), p[1].to_number<double>(), p[2].to_number<double>()};
  const config::Scenario& truth = cell_.scenario;
  const Eigen::Vector3d off_mm =
      p_mm - true_point_mm(cell_.devices.axes(), text_at(measurement, "smr"), truth);
  const Eigen::Vector3d &moved_mm = cell_.tracker_moved_mm,
                        &moved_before_mm = campaigns_.at(campaign).tracker_moved_mm;
  const double error_mm = (off_mm - moved_mm).norm();
  const double limit_mm = kSigmas * std::hypot(truth.repeatability_mm, truth.noise.range_mm);
  ++compared;
  const bool was_brought_back =
      moved_mm != moved_before_mm && (off_mm - moved_before_mm).norm() < kResumption_mm;
  if (was_brought_back) return;
  largest_error_mm = std::max(largest_error_mm, error_mm);
  if (error_mm > limit_mm)
    log_.broken("a point is " + std::to_string(error_mm) +
                " mm from the reflector: " + json::serialize(measurement));
}

asio::awaitable<void> PointJudge::compare_with_store(Client& client) {
  constexpr std::size_t kPage = 100;
  for (std::size_t offset = 0, listed = kPage; listed == kPage; offset += kPage) {
    json::object page{{"limit", kPage}, {"offset", offset}};
    const json::value answer = co_await client.ask("campaign.list", std::move(page));
    if (!is_result(answer)) co_return log_.broken("campaigns are not listed: " + json::serialize(answer));
    const json::array& campaigns = result_of(answer).at("campaigns").as_array();
    for (const json::value& campaign : campaigns)
      campaigns_[text_at(campaign.as_object(), "id")].points_of = text_at(campaign.as_object(), "points_of");
    listed = campaigns.size();
  }
  for (const auto& [id, campaign] : campaigns_) co_await compare(client, id);
}

asio::awaitable<void> PointJudge::compare(Client& client, std::string id) {
  stored_.clear();
  stored_poses_.clear();
  for (json::value next = 0; !next.is_null();) {
    json::object which{{"id", id}, {"limit", 1000}, {"offset", next}};
    const json::value answer = co_await client.ask("campaign.points", std::move(which));
    if (!is_result(answer))
      co_return log_.broken("the points of campaign " + id + " are lost: " + json::serialize(answer));
    for (const json::value& point : result_of(answer).at("points").as_array())
      judge_stored(id, point.as_object());
    next = result_of(answer).at("next");
  }
  for (const std::string& point : campaigns_.at(id).reported) {
    if (!stored_.contains(point))
      log_.broken("campaign " + id + ": the reported point " + point + " is lost");
  }
}

void PointJudge::judge_stored(const std::string& id, const json::object& point) {
  const std::string text = point_text(point);
  if (!stored_.insert(text).second) log_.broken("campaign " + id + " has a point twice: " + text);
  const std::string pose =
      text_at(point, "purpose") + ' ' + json::serialize(point.at("pose")) + ' ' + text_at(point, "smr");
  if (is_single(point) && !stored_poses_.insert(pose).second)
    log_.broken("campaign " + id + " has measured a pose twice: " + text);
  const std::string& points_of = campaigns_.at(id).points_of;
  // Of poses that a resumption measures again nothing is reported.
  if (text_at(point, "purpose") != "check" &&
      !campaigns_.at(points_of.empty() ? id : points_of).reported.contains(text))
    log_.broken("campaign " + id + " has a point that was never reported: " + text);
}

}  // namespace truepose::world
