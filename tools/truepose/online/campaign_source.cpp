#include "tools/truepose/online/campaign_source.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <cstdint>
#include <utility>
#include <vector>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "daemon/cell/campaign_archive.hpp"
#include "daemon/store/store.hpp"
#include "tools/truepose/online/rpc_client.hpp"

namespace truepose::tools {

namespace json = boost::json;

namespace {

class DaemonSource final : public CampaignSource {
 public:
  explicit DaemonSource(const OnlineOptions& online) : client_{value_or_throw(RpcClient::connect(online))} {}
  json::value ask(const std::string& method, const json::object& params) override {
    return value_or_throw(client_.call(method, params));
  }

 private:
  RpcClient client_;
};

template <typename T>
T read(daemon::StoreResult<T> result) {
  if (!result) throw CommandError{kBadInput, result.error().detail};
  return *std::move(result);
}

std::string text_in(const json::object& params, const char* key) {
  const json::value* const value = params.if_contains(key);
  return value ? std::string{value->as_string()} : "";
}

std::size_t number_in(const json::object& params, const char* key, std::size_t otherwise) {
  const json::value* const value = params.if_contains(key);
  return value ? value->to_number<std::size_t>() : otherwise;
}

void append(json::object& to, const json::object& page, const char* list) {
  const json::value* more = page.if_contains(list);
  if (more == nullptr) return;
  json::array& points = to[list].is_array() ? to[list].get_array() : to[list].emplace_array();
  for (const json::value& point : more->as_array()) points.push_back(point);
}

class StoreSource final : public CampaignSource {
 public:
  explicit StoreSource(const StoreFile& file)
      : file_{file}, store_{read(daemon::Store::open_to_read(file.store))} {}

  json::value ask(const std::string& method, const json::object& params) override {
    if (method == "campaign.list") return list();
    if (method == "report.get") return report(params);
    const daemon::StoredCampaign campaign = find(text_in(params, "id"));
    const RobotModel robot = robot_of(campaign);
    if (method == "campaign.get")
      return record::to_json(daemon::campaign_answer(campaign, robot, number_in(params, "points_offset", 0),
                                                     number_in(params, "points_limit", 0)));
    const std::string csv = daemon::measurements_csv(campaign, robot);
    const std::size_t offset = std::min(number_in(params, "offset", 0), csv.size());
    return record::to_json(
        rpc::CampaignExport::Result{.id = campaign.record.id, .offset = offset, .data = csv.substr(offset)});
  }

 private:
  json::value list() {
    rpc::CampaignList::Result list;
    for (const daemon::CampaignRecord& record : read(store_.campaigns()))
      list.campaigns.push_back(daemon::campaign_summary(record));
    list.total = static_cast<int>(list.campaigns.size());
    return record::to_json(list);
  }

  json::value report(const json::object& params) {
    const auto record = daemon::report_record(store_, text_in(params, "id"));
    if (!record && record.error().code == control::ErrorCode::Store)
      throw CommandError{kBadInput, record.error().message};
    if (!record) throw CommandError{kFailed, file_.store.string() + ": " + record.error().message};
    auto answer = daemon::report_answer(*record, number_in(params, "points_offset", 0),
                                        number_in(params, "points_limit", SIZE_MAX));
    if (!answer) throw CommandError{kFailed, file_.store.string() + ": " + answer.error().message};
    return record::to_json(*answer);
  }

  daemon::StoredCampaign find(const std::string& id) {
    auto found = read(daemon::read_campaign(store_, id));
    if (!found) throw CommandError{kFailed, file_.store.string() + ": no such campaign"};
    return *std::move(found);
  }

  /// The arm whose joints a campaign's points are, as far as units go.
  RobotModel robot_of(const daemon::StoredCampaign& campaign) {
    if (!file_.robot.empty()) return config::load_robot(file_.robot);
    std::vector<std::string> ids{campaign.record.model_id};
    for (const daemon::ModelRecord& model : read(store_.models())) ids.push_back(model.id);
    const auto joints = campaign.points.empty() ? 0 : campaign.points.front().q_actual.size();
    for (const std::string& id : ids) {
      const auto model = read(store_.model(id));
      if (!model) continue;
      RobotModel robot = config::parse_model(model->yaml, "model " + id).cell.robot;
      if (joints == 0 || robot.joint_count() == joints) return robot;
    }
    if (joints == 0) return {};
    throw CommandError{kBadInput, file_.store.string() +
                                      ": no model in it says which of the joints turn: give --robot FILE"};
  }

  StoreFile file_;
  daemon::Store store_;
};

}  // namespace

json::object whole_report(CampaignSource& source, const std::string& id) {
  constexpr std::int64_t kPage = 50;
  json::object document;
  std::string found = id;
  for (std::int64_t offset = 0, total = 1; offset < total; offset += kPage) {
    json::object params{{"points_offset", offset}, {"points_limit", kPage}};
    if (!found.empty()) params["id"] = found;
    const json::value reply = source.ask("report.get", params);
    found = reply.at("id").as_string();
    total = reply.at("points_total").to_number<std::int64_t>();
    const json::object& page = reply.at("document").as_object();
    if (offset == 0) {
      document = page;
      continue;
    }
    for (const char* list : {"points", "remeasured_points", "skipped"}) append(document, page, list);
  }
  return document;
}

std::unique_ptr<CampaignSource> campaign_source(const OnlineOptions& online, const StoreFile& file) {
  if (file.store.empty()) return std::make_unique<DaemonSource>(online);
  return std::make_unique<StoreSource>(file);
}

}  // namespace truepose::tools
