#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <expected>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/control/control_server.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rpc/campaign.hpp"
#include "proto/rpc/cell.hpp"
#include "proto/rpc/model.hpp"

namespace truepose::tools {

inline boost::json::object progress(const char* phase, int done) {
  return {{"id", "c1"},  {"kind", "calibration"}, {"phase", phase}, {"done", done},
          {"total", 60}, {"error_mm", 0.0427},    {"eta_s", 80.0}};
}

/// Answers with what a cell would say, and lets a campaign run to its end as soon as it is asked about.
class FakeCell : public daemon::CellService {
 public:
  explicit FakeCell(daemon::EventBus& events) : events_{events} {}
  boost::asio::awaitable<std::expected<boost::json::value, control::RpcError>> pause(std::string,
                                                                                     std::string) override {
    co_return boost::json::object{};
  }
  std::vector<std::string> methods() const override {
    return {"cell.status",    "cell.connect", "campaign.start", "campaign.get", "campaign.list",
            "campaign.pause", "model.list",   "model.get",      "model.export"};
  }
  boost::asio::awaitable<std::expected<boost::json::value, control::RpcError>> call(
      std::string method, boost::json::object params, std::string) override {
    if (method == "cell.connect")
      co_return std::unexpected(control::RpcError{control::ErrorCode::Device, "the tracker does not answer"});
    if (method == "campaign.pause")
      co_return std::unexpected(control::RpcError{
          control::ErrorCode::WrongState, "no campaign runs", "", "ready", {"campaign.start"}});
    boost::json::value result = answers.at(method);
    if (const boost::json::value* id = params.if_contains("id")) asked_id = std::string{id->as_string()};
    if (method == "campaign.start") result.as_object()["asked"] = params;
    if (method == "campaign.get") {
      boost::json::object other = progress("failed", 3);
      other["id"] = "another";
      events_.publish(control::Topic::Campaign, other);
      events_.publish(control::Topic::Campaign, progress("validating", 31));
      const auto tell = [this](const char* state, const char* reason) {
        events_.publish(control::Topic::Cell,
                        boost::json::object{{"state", state}, {"from", "campaign"}, {"reason", reason}});
      };
      tell("campaign", "the tracker answers");
      tell("ready", "no one asks for this one");
      events_.publish(control::Topic::Log,
                      boost::json::object{{"level", "info"}, {"text", "nor for this one"}});
      events_.publish(control::Topic::Log,
                      boost::json::object{{"level", "warning"},
                                          {"text", "pose 12, attempt 1 of 3: tracker: the beam was broken"}});
      boost::json::object last = progress(final_phase, 60);
      last["kind"] = kind;
      last["skipped"] = 1;
      last["model_id"] =
          std::string_view{kind} == "calibration" ? boost::json::value("m1") : boost::json::value{};
      events_.publish(control::Topic::Campaign, last);
    }
    co_return result;
  }
  const char* kind = "calibration";
  const char* final_phase = "done";
  std::string asked_id;  ///< of the last call that named one
  std::map<std::string, boost::json::value> answers{
      {"cell.status", record::to_json(status())},
      {"campaign.start", {{"id", "c1"}, {"total", 60}}},
      {"campaign.get", record::to_json(running())},
      {"campaign.list", record::to_json(campaigns({"c1"}))},
      {"model.list", {{"models", boost::json::array{record::to_json(model())}}, {"total", 1}}},
      {"model.get", {{"model", record::to_json(model())}, {"parameters", boost::json::array{}}}},
      {"model.export", {{"id", "m1"}, {"yaml", "name: KR\n"}}}};

  static rpc::CellStatus status() {
    rpc::CellStatus status{
        .cell = "cell 1", .state = "ready", .state_text = "waits for a command", .next = "Start a campaign."};
    status.robot = {.connected = true, .model = "#KR210", .serial = "42", .why_not_ready = "drives off"};
    status.stream.state = "off";
    status.recording = {.seconds = 61, .bytes = 2345};
    status.faults = {{.code = "E_BEAM", .severity = "warning", .text = "beam broken", .since = "s"}};
    return status;
  }
  static rpc::CampaignGet::Result running() {
    rpc::CampaignGet::Result found;
    found.campaign = {.id = "c1", .kind = "calibration", .state = "running"};
    found.progress = {.id = "c1", .kind = "calibration", .phase = "identifying", .done = 3, .total = 60};
    return found;
  }
  /// Newest first, as the daemon lists them.
  static rpc::CampaignList::Result campaigns(const std::vector<std::string>& ids) {
    rpc::CampaignList::Result list{.total = static_cast<int>(ids.size())};
    for (const std::string& id : ids)
      list.campaigns.push_back({.id = id,
                                .kind = "calibration",
                                .started = "2026-01-31T12:00:00.000Z",
                                .state = "done",
                                .model_id = id});
    return list;
  }
  static rpc::ModelSummary model() {
    return {.id = "m1",
            .created = "t",
            .robot_serial = "42",
            .validation_before_mm = 2.5,
            .validation_after_mm = 0.0421,
            .active = true};
  }

 private:
  daemon::EventBus& events_;
};

}  // namespace truepose::tools
