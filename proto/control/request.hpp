#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <expected>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/named.hpp"

namespace truepose::control {

/// Error codes on the wire: those of JSON-RPC 2.0, then ours.
enum class ErrorCode : int {
  ParseError = -32700,
  InvalidRequest = -32600,
  MethodNotFound = -32601,
  InvalidParams = -32602,
  Internal = -32603,
  Unauthenticated = -32001,
  Forbidden = -32002,
  WrongState = -32003,
  NotFound = -32004,
  Device = -32005,
  Busy = -32006,
  RateLimited = -32007,
  NotInControl = -32008,
  Store = -32009,
};

/// The stable name that programs may branch on, sent as error.data.code: "E_STATE".
std::string_view symbol(ErrorCode code);

/// Why a request was not carried out.
struct RpcError {
  ErrorCode code = ErrorCode::Internal;
  std::string message;                 ///< one sentence for the operator
  std::string path{};                  ///< offending parameter ("params.poses"), InvalidParams
  std::string state{};                 ///< the present state, WrongState
  std::vector<std::string> allowed{};  ///< methods that this state allows, WrongState
};

enum class Topic { Cell, Campaign, Measurement, Stream, Model, Fault, Log, Control };
/// What events are about, by its name on the wire.
inline constexpr std::array kTopics{Named{"cell", Topic::Cell},
                                    Named{"campaign", Topic::Campaign},
                                    Named{"measurement", Topic::Measurement},
                                    Named{"stream", Topic::Stream},
                                    Named{"model", Topic::Model},
                                    Named{"fault", Topic::Fault},
                                    Named{"log", Topic::Log},
                                    Named{"control", Topic::Control}};
inline std::string_view name(Topic topic) { return name_of(kTopics, topic); }
std::optional<Topic> topic_from_name(std::string_view name);

/// Id of a request; none for a notification, which is never answered (nor are its params read).
using Id = std::variant<std::monostate, std::int64_t, std::string>;

struct Request {
  Id id;
  std::string method;
  boost::json::object params;  ///< empty where the line had none

  bool is_notification() const { return std::holds_alternative<std::monostate>(id); }
};

/// A line that is not a request, with the id to answer it under where one could be read.
struct BadRequest {
  Id id;
  RpcError error;
};

/// Reads one line (without its newline). Stricter than JSON-RPC 2.0 where that is vague: no batches, ids are
/// strings or integers, params are an object.
std::expected<Request, BadRequest> decode_request(std::string_view line);

/// Lines below end with their newline.
std::string encode_request(const Id& id, std::string_view method, const boost::json::object& params);
std::string encode_result(const Id& id, const boost::json::value& result);
std::string encode_error(const Id& id, const RpcError& error);
std::string encode_notification(std::string_view method, const boost::json::object& params);
/// @param time  RFC 3339
/// @param data  JSON text, on one line
std::string encode_event_text(std::uint64_t seq, std::string_view time, Topic topic, std::string_view data);

/// How many events a client did not get, by their topics.
using Dropped = std::map<Topic, std::uint64_t>;
/// The line of an event, which also says how many were dropped before it.
std::string event_after_drops(std::string_view event_line, const Dropped& dropped);

/// What an error says for programs: {"code", ...}.
boost::json::object error_data(const RpcError& error);

struct Reply {
  Id id;
  std::expected<boost::json::value, RpcError> result;
};

struct Event {
  std::uint64_t seq = 0;
  std::string time;   ///< RFC 3339
  std::string topic;  ///< a name, since a newer server may know more topics
  boost::json::object data;
  boost::json::object dropped{};  ///< how many were dropped before it, by the names of their topics
};

/// Whatever else the server tells unasked: the greeting, the progress of jobs, and what a newer one may tell.
struct Notification {
  std::string method;
  boost::json::object params;
};

using ServerMessage = std::variant<Reply, Event, Notification>;

/// Reads one line that a server sent; the error is one sentence.
std::expected<ServerMessage, std::string> decode_server_line(std::string_view line);

}  // namespace truepose::control
