#include "proto/rpc/methods.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <map>
#include <string>
#include <utility>

#include "proto/record/drift_document.hpp"
#include "proto/record/frame_document.hpp"
#include "proto/record/schema_io.hpp"
#include "proto/rpc/backup.hpp"
#include "proto/rpc/campaign.hpp"
#include "proto/rpc/cell.hpp"
#include "proto/rpc/control.hpp"
#include "proto/rpc/drift.hpp"
#include "proto/rpc/events.hpp"
#include "proto/rpc/model.hpp"
#include "proto/rpc/recording.hpp"
#include "proto/rpc/report.hpp"
#include "proto/rpc/session.hpp"
#include "proto/rpc/stream.hpp"
#include "proto/rpc/targets.hpp"
#include "proto/rpc/tool.hpp"

namespace truepose::rpc {
namespace {

namespace json = boost::json;
using record::Definitions, record::Message;

constexpr const char* kSchemas = "#/components/schemas/";

json::string_view view_of(std::string_view text) { return {text.data(), text.size()}; }

json::object reference(const char* schema) { return {{"$ref", std::string{kSchemas} + schema}}; }

std::string_view name_of_error(ErrorCode code) {
  switch (code) {
    case ErrorCode::ParseError:
      return "ParseError";
    case ErrorCode::InvalidRequest:
      return "InvalidRequest";
    case ErrorCode::MethodNotFound:
      return "MethodNotFound";
    case ErrorCode::InvalidParams:
      return "InvalidParams";
    case ErrorCode::Internal:
      return "Internal";
    case ErrorCode::Unauthenticated:
      return "Unauthenticated";
    case ErrorCode::Forbidden:
      return "Forbidden";
    case ErrorCode::WrongState:
      return "WrongState";
    case ErrorCode::NotFound:
      return "NotFound";
    case ErrorCode::Device:
      return "Device";
    case ErrorCode::Busy:
      return "Busy";
    case ErrorCode::RateLimited:
      return "RateLimited";
    case ErrorCode::NotInControl:
      return "NotInControl";
    case ErrorCode::Store:
      return "Store";
  }
  return "Internal";
}

/// Each parameter by its name, and what every command and every long method takes besides.
json::array described_params(const Described& described, Definitions& definitions) {
  json::object schema = record::described_schema(described.params, Message::Request, definitions);
  json::array params;
  const auto add = [&params](std::string_view name, bool required, json::value type) {
    params.push_back(
        json::object{{"name", view_of(name)}, {"required", required}, {"schema", std::move(type)}});
  };
  const json::value required =
      schema.contains("required") ? std::move(schema.at("required")) : json::value(json::array{});
  for (auto& [name, type] : schema.at("properties").as_object())
    add(name, std::ranges::count(required.as_array(), json::value(name)) > 0, std::move(type));
  if (described.method->role > Role::Viewer) add("command_id", false, reference("CommandId"));
  if (described.method->is_long) add("job", false, reference("AsJob"));
  return params;
}

json::object described_method(const Described& described, json::value examples, Definitions& definitions) {
  const Method& method = *described.method;
  json::object one{{"name", view_of(method.name)}, {"x-role", view_of(control::name(method.role))}};
  if (method.is_always_carried_out) one["x-always"] = true;
  one["summary"] = view_of(method.summary);
  one["paramStructure"] = "by-name";
  if (!method.description.empty()) one["description"] = view_of(method.description);
  one["params"] = described_params(described, definitions);
  one["result"] = {{"name", "result"},
                   {"schema", record::described_schema(described.result, Message::Answer, definitions)}};
  json::array errors;
  for (const ErrorCode code : method.errors)
    errors.push_back(json::object{{"$ref", "#/components/errors/" + std::string{name_of_error(code)}}});
  one["errors"] = std::move(errors);
  if (!examples.is_null()) one["examples"] = std::move(examples);
  return one;
}

/// The data of each event.
using Events = std::map<control::Topic, void (*)(Io&)>;
template <Event... Data>
Events events_of() {
  return {{Data::kTopic, describe<Data>}...};
}
const Events& events() {
  static const Events kEvents = events_of<StateChanged, CampaignProgress, PointMeasured, StreamStatus,
                                          ModelChanged, FaultChanged, LogLine, ControlChanged>();
  return kEvents;
}

}  // namespace

const std::vector<Described>& methods() {
  static const std::vector<Described> kMethods = [] {
    std::vector<Described> all;
    for (const auto& part :
         {session_methods(), control_methods(), cell_methods(), campaign_methods(), drift_methods(),
          model_methods(), tool_methods(), stream_methods(), recording_methods(), backup_methods(),
          targets_methods(), events_methods(), report_methods()})
      all.insert(all.end(), part.begin(), part.end());
    return all;
  }();
  return kMethods;
}

const Method* method_named(std::string_view name) {
  const auto named = [](const Described& one) { return one.method->name; };
  const auto found = std::ranges::find(methods(), name, named);
  return found == methods().end() ? nullptr : found->method;
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Described& one : methods()) names.emplace_back(one.method->name);
  std::ranges::sort(names);
  return names;
}

json::object described_protocol(json::object document) {
  Definitions definitions{.place = kSchemas, .may_grow = true};
  for (const auto document_of_campaign : {describe<record::DriftDocument>, describe<TargetsDocument>,
                                          describe<Iso9283Document>, describe<record::FrameDocument>})
    record::described_schema(document_of_campaign, Message::Answer, definitions);
  std::map<std::string, json::value> examples;
  for (auto& method : document.at("methods").as_array())
    if (auto* given = method.as_object().if_contains("examples"))
      examples[std::string{method.at("name").as_string()}] = std::move(*given);
  json::array all;
  for (const Described& described : methods())
    all.push_back(
        described_method(described, std::move(examples[std::string{described.method->name}]), definitions));
  document["methods"] = std::move(all);
  for (auto& event : document.at("x-events").as_array()) {
    const auto topic = control::topic_from_name(std::string_view{event.at("topic").as_string()});
    event.as_object()["data"] =
        record::described_schema(events().at(topic.value()), Message::Answer, definitions);
  }
  json::object& schemas = document.at("components").as_object().at("schemas").as_object();
  json::object kept;
  for (const char* const name : {"CommandId", "AsJob", "CalibrationDocument", "CellConfig"})
    kept[name] = schemas.at(name);
  for (auto& [name, schema] : definitions.schemas) kept[name] = std::move(schema);
  schemas = std::move(kept);
  return document;
}

}  // namespace truepose::rpc
