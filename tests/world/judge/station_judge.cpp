#include "tests/world/judge/station_judge.hpp"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>
#include <optional>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

bool rests(const std::string& phase) {
  constexpr std::array kRest{"interrupted", "done", "aborted", "failed"};
  return std::ranges::find(kRest, phase) != kRest.end();
}

std::string text_of(const Eigen::Vector3d& v_mm) {
  return std::to_string(v_mm.x()) + ", " + std::to_string(v_mm.y()) + ", " + std::to_string(v_mm.z()) + " mm";
}

/// Of the cause that explains a drift best: by how much the base moves, as the tracker sees it.
std::optional<Eigen::Vector3d> base_moved_mm(const json::object& drift) {
  const json::array& causes = drift.at("causes").as_array();
  if (causes.empty() || text_at(causes.front().as_object(), "kind") != "base") return std::nullopt;
  const json::array& moved = causes.front().as_object().at("moved").as_array();
  return Eigen::Vector3d{moved[0].to_number<double>(), moved[1].to_number<double>(),
                         moved[2].to_number<double>()};
}

}  // namespace

void StationJudge::look() {
  measures_ = measures_ && cell_.pc.runs();
  if (measures_ && cell_.tracker_moved_mm != last_moved_mm_) is_clear_ = false;
  last_moved_mm_ = cell_.tracker_moved_mm;
}

void StationJudge::take_progress(const json::object& progress) {
  look();
  const std::string id = text_at(progress, "id");
  if (id != campaign_) {
    is_clear_ = true;
    campaign_began_ = log_.now();
  }
  campaign_ = id;
  measures_ = !rests(text_at(progress, "phase"));
  if (measures_) measured_at_mm_ = last_moved_mm_;
}

void StationJudge::take_change(const json::object& change) {
  look();
  if (text_at(change, "change") != "made") return;
  const json::object& model = change.at("model").as_object();
  // A wrong reading may pass for a tracker that has moved.
  const bool is_wrong = log_.had_fault({"tracker-biased", "other-reflector"}, log_.now() - campaign_began_);
  if (text_at(model, "campaign_id") == campaign_ && is_clear_ && !is_wrong)
    made_.emplace(text_at(model, "id"), measured_at_mm_);
}

asio::awaitable<void> StationJudge::before_check(Client& client) {
  model_.clear();
  began_ = log_.now();
  const json::value answer = co_await client.ask("model.get");
  if (is_result(answer)) model_ = text_at(result_of(answer).at("model").as_object(), "id");
}

asio::awaitable<void> StationJudge::after_check(Client& client, std::string campaign) {
  const auto model = made_.find(model_);
  if (campaign != campaign_ || !is_clear_ || model == made_.end()) co_return;
  if (log_.had_fault({"tracker-biased", "tracker-scattering", "other-reflector"}, log_.now() - began_))
    co_return;
  json::object which{{"id", std::move(campaign)}};
  const json::value answer = co_await client.ask("campaign.get", std::move(which));
  if (!is_result(answer) || result_of(answer).at("drift").is_null()) co_return;
  ++checks;
  judge(result_of(answer).at("drift").as_object(), measured_at_mm_ - model->second);
}

void StationJudge::judge(const json::object& drift, const Eigen::Vector3d& moved_mm) {
  constexpr double kClear_mm = 0.5;  // beyond what chance shows
  const std::string verdict = text_at(drift, "verdict");
  log_.trace("station", verdict + ", the tracker has moved by " + text_of(moved_mm));
  if (moved_mm.isZero()) {
    if (verdict == "failed")
      log_.broken("a drift check fails, and nothing has moved: " + json::serialize(drift));
  } else if (moved_mm.norm() > kClear_mm) {
    const auto found_mm = base_moved_mm(drift);
    if (verdict == "ok" || !found_mm || (*found_mm - moved_mm).norm() > kClear_mm)
      log_.broken("a drift check does not find that the tracker has moved by " + text_of(moved_mm) + ": " +
                  json::serialize(drift));
  }
}

}  // namespace truepose::world
