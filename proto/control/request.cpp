#include "proto/control/request.hpp"

#include <algorithm>

#include "proto/control/json_text.hpp"

namespace truepose::control {
namespace {

namespace json = boost::json;

/// Id of a message; nothing if it has one of a wrong kind. An absent id is a monostate.
std::optional<Id> read_id(const json::object& message) {
  std::optional<Id> id{std::in_place};
  const json::value* value = message.if_contains("id");
  if (!value) return id;
  if (const auto* integer = value->if_int64()) {
    id->emplace<std::int64_t>(*integer);
  } else if (const auto* text = value->if_string()) {
    id->emplace<std::string>(text->data(), text->size());
  } else {
    id.reset();
  }
  return id;
}

json::value id_value(const Id& id) {
  if (const auto* integer = std::get_if<std::int64_t>(&id)) return *integer;
  if (const auto* text = std::get_if<std::string>(&id)) return json::value(*text);
  return nullptr;
}

std::string text_of(const json::object& object, std::string_view key) {
  const json::value* value = object.if_contains(json::string_view{key.data(), key.size()});
  if (!value || !value->is_string()) return {};
  return std::string{value->get_string().data(), value->get_string().size()};
}

bool is_version_2(const json::object& message) { return text_of(message, "jsonrpc") == "2.0"; }

// Parentheses: braces around a value make it a list of one.
std::string line_of(json::object message) { return json_text(json::value(std::move(message))) + '\n'; }

json::string_view view(std::string_view text) { return {text.data(), text.size()}; }

RpcError read_error(const json::object& error) {
  RpcError read{ErrorCode::Internal, text_of(error, "message")};
  if (const json::value* code = error.if_contains("code"); code && code->is_int64())
    read.code = static_cast<ErrorCode>(code->get_int64());
  const json::value* data = error.if_contains("data");
  if (!data || !data->is_object()) return read;
  read.path = text_of(data->get_object(), "path");
  read.state = text_of(data->get_object(), "state");
  const json::value* allowed = data->get_object().if_contains("allowed");
  if (!allowed || !allowed->is_array()) return read;
  for (const json::value& method : allowed->get_array())
    if (method.is_string()) read.allowed.emplace_back(method.get_string().data(), method.get_string().size());
  return read;
}

}  // namespace

std::string_view symbol(ErrorCode code) {
  static constexpr std::array kSymbols{Named{"E_PARSE", ErrorCode::ParseError},
                                       Named{"E_REQUEST", ErrorCode::InvalidRequest},
                                       Named{"E_METHOD", ErrorCode::MethodNotFound},
                                       Named{"E_PARAMS", ErrorCode::InvalidParams},
                                       Named{"E_INTERNAL", ErrorCode::Internal},
                                       Named{"E_UNAUTHENTICATED", ErrorCode::Unauthenticated},
                                       Named{"E_FORBIDDEN", ErrorCode::Forbidden},
                                       Named{"E_STATE", ErrorCode::WrongState},
                                       Named{"E_NOT_FOUND", ErrorCode::NotFound},
                                       Named{"E_DEVICE", ErrorCode::Device},
                                       Named{"E_BUSY", ErrorCode::Busy},
                                       Named{"E_RATE", ErrorCode::RateLimited},
                                       Named{"E_CONTROL", ErrorCode::NotInControl},
                                       Named{"E_STORE", ErrorCode::Store}};
  const auto* const found = std::ranges::find(kSymbols, code, &Named<ErrorCode>::value);
  return found == kSymbols.end() ? "E_INTERNAL" : found->name;
}

std::optional<Topic> topic_from_name(std::string_view name) {
  const auto* const found = std::ranges::find(kTopics, name, &Named<Topic>::name);
  return found == kTopics.end() ? std::nullopt : std::optional{found->value};
}

std::expected<Request, BadRequest> decode_request(std::string_view line) {
  auto parsed = parse_json(line);
  if (!parsed)
    return std::unexpected(BadRequest{{}, {ErrorCode::ParseError, "unreadable JSON: " + parsed.error()}});
  const auto invalid = [](Id id, std::string why) {
    return std::unexpected(BadRequest{std::move(id), {ErrorCode::InvalidRequest, std::move(why)}});
  };
  if (parsed->is_array()) return invalid({}, "batches are not served: send one request a line");
  if (!parsed->is_object()) return invalid({}, "a request is a JSON object");
  json::object& message = parsed->get_object();

  const auto id = read_id(message);
  if (!id) return invalid({}, "id: expected a string or an integer");
  for (const auto& [key, value] : message)
    if (key != "jsonrpc" && key != "id" && key != "method" && key != "params")
      return invalid(*id, "unknown member \"" + std::string{key.data(), key.size()} + "\"");
  if (!is_version_2(message)) return invalid(*id, "jsonrpc: expected \"2.0\"");
  Request request{*id, text_of(message, "method"), {}};
  if (request.method.empty()) return invalid(*id, "method: expected a name");
  if (json::value* params = message.if_contains("params"); params && !request.is_notification()) {
    if (!params->is_object())
      return std::unexpected(BadRequest{
          *id, {ErrorCode::InvalidParams, "params: expected an object with named parameters", "params"}});
    request.params = std::move(params->get_object());
  }
  return request;
}

std::string encode_request(const Id& id, std::string_view method, const json::object& params) {
  json::object message{{"jsonrpc", "2.0"}};
  if (!std::holds_alternative<std::monostate>(id)) message["id"] = id_value(id);
  message["method"] = view(method);
  message["params"] = params;
  return line_of(std::move(message));
}

std::string encode_result(const Id& id, const json::value& result) {
  return line_of({{"jsonrpc", "2.0"}, {"id", id_value(id)}, {"result", result}});
}

json::object error_data(const RpcError& error) {
  json::object data{{"code", view(symbol(error.code))}};
  if (!error.path.empty()) data["path"] = error.path;
  if (!error.state.empty()) {
    data["state"] = error.state;
    data["allowed"] = json::array(error.allowed.begin(), error.allowed.end());
  }
  return data;
}

std::string encode_error(const Id& id, const RpcError& error) {
  json::object written{
      {"code", static_cast<int>(error.code)}, {"message", error.message}, {"data", error_data(error)}};
  return line_of({{"jsonrpc", "2.0"}, {"id", id_value(id)}, {"error", std::move(written)}});
}

std::string encode_notification(std::string_view method, const json::object& params) {
  return encode_request({}, method, params);
}

std::string encode_event_text(std::uint64_t seq, std::string_view time, Topic topic, std::string_view data) {
  std::string line = R"({"jsonrpc":"2.0","method":"event","params":{"seq":)" + std::to_string(seq);
  line += R"(,"time":)" + json_text(json::value(view(time)));
  line += R"(,"topic":)" + json_text(json::value(view(name(topic))));
  (line += R"(,"data":)") += data;
  return line += "}}\n";
}

std::string event_after_drops(std::string_view event_line, const Dropped& dropped) {
  json::object counts;
  for (const auto& [topic, count] : dropped) counts[view(name(topic))] = count;
  constexpr std::string_view kEnd = "}}\n";  // of the parameters and of the message
  std::string line{event_line.substr(0, event_line.size() - kEnd.size())};
  return line + ",\"dropped\":" + json_text(counts) + std::string{kEnd};
}

namespace {

json::object object_of(json::object& message, std::string_view key) {
  json::value* const value = message.if_contains(view(key));
  return value && value->is_object() ? std::move(value->get_object()) : json::object{};
}

}  // namespace

std::expected<ServerMessage, std::string> decode_server_line(std::string_view line) {
  auto parsed = parse_json(line);
  if (!parsed) return std::unexpected("the server sent unreadable JSON: " + parsed.error());
  const auto strange = [](std::string_view what) {
    return std::unexpected("the server sent a line that is no " + std::string{what});
  };
  if (!parsed->is_object() || !is_version_2(parsed->get_object())) return strange("JSON-RPC 2.0 message");
  json::object& message = parsed->get_object();

  if (json::value* method = message.if_contains("method")) {
    json::value* params = message.if_contains("params");
    if (!method->is_string()) return strange("event");
    if (*method != "event") return Notification{text_of(message, "method"), object_of(message, "params")};
    if (!params || !params->is_object()) return strange("event");
    json::object& event = params->get_object();
    json::value* data = event.if_contains("data");
    const json::value* number = event.if_contains("seq");
    boost::system::error_code not_a_number;
    const auto seq = number ? number->to_number<std::uint64_t>(not_a_number) : 0;
    if (!number || not_a_number || !data || !data->is_object()) return strange("event");
    return Event{seq, text_of(event, "time"), text_of(event, "topic"), std::move(data->get_object()),
                 object_of(event, "dropped")};
  }

  json::value* result = message.if_contains("result");
  const json::value* error = message.if_contains("error");
  const json::value* id = message.if_contains("id");
  if (!id || (result != nullptr) == (error != nullptr)) return strange("reply");
  const auto known_id = id->is_null() ? Id{} : read_id(message);
  if (!known_id) return strange("reply");
  if (result) return Reply{*known_id, std::move(*result)};
  if (!error->is_object()) return strange("reply");
  return Reply{*known_id, std::unexpected(read_error(error->get_object()))};
}

}  // namespace truepose::control
