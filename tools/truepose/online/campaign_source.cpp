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

namespace truepose::tools {

namespace json = boost::json;

namespace {

class DaemonSource final : public CampaignSource {
 public:
  explicit DaemonSource(const OnlineOptions& online) : client_{value_or_throw(RpcClient::connect(online))} {}
  Received<rpc::CampaignList::Result> ask(const rpc::CampaignList& request) override {
    return value_or_throw(client_.call(request));
  }
  Received<rpc::CampaignGet::Result> ask(const rpc::CampaignGet& request) override {
    return value_or_throw(client_.call(request));
  }
  rpc::CampaignExport::Result ask(const rpc::CampaignExport& request) override {
    return value_or_throw(client_.call(request)).record;
  }
  rpc::ReportGet::Result ask(const rpc::ReportGet& request) override {
    return value_or_throw(client_.call(request)).record;
  }

 private:
  RpcClient client_;
};

template <typename T>
T read(daemon::StoreResult<T> result) {
  if (!result) throw CommandError{kBadInput, result.error().detail};
  return *std::move(result);
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

  Received<rpc::CampaignList::Result> ask(const rpc::CampaignList&) override {
    rpc::CampaignList::Result list;
    for (const daemon::CampaignRecord& record : read(store_.campaigns()))
      list.campaigns.push_back(daemon::campaign_summary(record));
    list.total = static_cast<int>(list.campaigns.size());
    return {record::to_json(list), list};
  }

  Received<rpc::CampaignGet::Result> ask(const rpc::CampaignGet& request) override {
    const daemon::StoredCampaign campaign = find(request.id.value_or(""));
    const rpc::CampaignGet::Result found = daemon::campaign_answer(
        campaign, robot_of(campaign), request.points_offset, static_cast<std::size_t>(request.points_limit));
    return {record::to_json(found), found};
  }

  rpc::CampaignExport::Result ask(const rpc::CampaignExport& request) override {
    const daemon::StoredCampaign campaign = find(request.id.value_or(""));
    const std::string csv = daemon::measurements_csv(campaign, robot_of(campaign));
    const std::size_t offset = std::min<std::size_t>(request.offset, csv.size());
    return {campaign.record.id, offset, csv.substr(offset)};
  }

  rpc::ReportGet::Result ask(const rpc::ReportGet& request) override {
    const auto record = daemon::report_record(store_, request.id.value_or(""));
    if (!record && record.error().code == control::ErrorCode::Store)
      throw CommandError{kBadInput, record.error().message};
    if (!record) throw CommandError{kFailed, file_.store.string() + ": " + record.error().message};
    auto report =
        daemon::report_answer(*record, request.points_offset, static_cast<std::size_t>(request.points_limit));
    if (!report) throw CommandError{kFailed, file_.store.string() + ": " + report.error().message};
    return *std::move(report);
  }

 private:
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

std::optional<std::string> unless_empty(const std::string& id) {
  return id.empty() ? std::nullopt : std::optional{id};
}

json::object whole_report(CampaignSource& source, const std::string& id) {
  constexpr int kPage = 50;
  rpc::ReportGet request{.id = unless_empty(id), .points_limit = kPage};
  json::object document;
  for (std::uint64_t total = 1; request.points_offset < total; request.points_offset += kPage) {
    rpc::ReportGet::Result page = source.ask(request);
    request.id = page.id;
    total = page.points_total;
    if (request.points_offset == 0) {
      document = std::move(page.document);
      continue;
    }
    for (const char* list : {"points", "remeasured_points", "skipped"}) append(document, page.document, list);
  }
  return document;
}

std::unique_ptr<CampaignSource> campaign_source(const OnlineOptions& online, const StoreFile& file) {
  if (file.store.empty()) return std::make_unique<DaemonSource>(online);
  return std::make_unique<StoreSource>(file);
}

}  // namespace truepose::tools
