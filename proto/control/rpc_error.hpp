#pragma once

#include <string>
#include <string_view>
#include <vector>

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

}  // namespace truepose::control
