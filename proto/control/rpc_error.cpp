#include "proto/control/rpc_error.hpp"

namespace truepose::control {

std::string_view symbol(ErrorCode code) {
  switch (code) {
    case ErrorCode::ParseError:
      return "E_PARSE";
    case ErrorCode::InvalidRequest:
      return "E_REQUEST";
    case ErrorCode::MethodNotFound:
      return "E_METHOD";
    case ErrorCode::InvalidParams:
      return "E_PARAMS";
    case ErrorCode::Internal:
      return "E_INTERNAL";
    case ErrorCode::Unauthenticated:
      return "E_UNAUTHENTICATED";
    case ErrorCode::Forbidden:
      return "E_FORBIDDEN";
    case ErrorCode::WrongState:
      return "E_STATE";
    case ErrorCode::NotFound:
      return "E_NOT_FOUND";
    case ErrorCode::Device:
      return "E_DEVICE";
    case ErrorCode::Busy:
      return "E_BUSY";
    case ErrorCode::RateLimited:
      return "E_RATE";
  }
  return "E_INTERNAL";
}

}  // namespace truepose::control
