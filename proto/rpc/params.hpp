#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <expected>

#include "proto/record/json_io.hpp"
#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// Reads the parameters of a call. An unknown one is refused.
template <Request T>
std::expected<T, control::RpcError> read_params(const boost::json::object& params) {
  T x{};
  const auto read =
      record::read_json(params, "params", record::Others::Refused, [&x](Io& io) { io.value(x); });
  if (read) return x;
  return std::unexpected(control::RpcError{ErrorCode::InvalidParams, read.error().text, read.error().place});
}

/// Reads parameters that are not the method's own, and takes them away.
template <class T>
std::expected<T, control::RpcError> take_params(boost::json::object& params) {
  T x{};
  const auto read =
      record::read_json(params, "params", record::Others::Passed, [&x](Io& io) { io.value(x); });
  if (!read)
    return std::unexpected(
        control::RpcError{ErrorCode::InvalidParams, read.error().text, read.error().place});
  for (const std::string& key : record::keys_of([&x](Io& io) { layout(io, x); })) params.erase(key);
  return x;
}

/// Refuses a parameter that reads well but makes no sense now.
inline std::unexpected<control::RpcError> refused(std::string_view param, std::string_view why) {
  const std::string path = "params." + std::string{param};
  return std::unexpected(control::RpcError{ErrorCode::InvalidParams, path + ": " + std::string{why}, path});
}

}  // namespace truepose::rpc
