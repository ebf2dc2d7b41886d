#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <expected>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "proto/rpc/params.hpp"

namespace truepose::daemon {

using MethodResult = std::expected<boost::json::value, control::RpcError>;
using MethodReply = boost::asio::awaitable<MethodResult>;

/// The answer to a request, a record.
template <rpc::Request R>
using Answer = std::expected<typename R::Result, control::RpcError>;
template <rpc::Request R>
using Reply = boost::asio::awaitable<Answer<R>>;

/// Reads a request from parameters, has it carried out, and writes the answer.
template <rpc::Request R>
MethodReply replied(boost::json::object params, std::function<Reply<R>(R)> carry_out) {
  auto request = rpc::read_params<R>(params);
  if (!request) co_return std::unexpected(request.error());
  auto answer = co_await carry_out(*std::move(request));
  if (!answer) co_return std::unexpected(answer.error());
  co_return record::value_json(*answer);
}

/// A request of the control protocol and who carries it out. Some want to know by whom it was sent.
template <typename Service>
struct Served {
  // Not explicit: a list of members is a list of these.
  template <rpc::Request R>
  Served(Reply<R> (Service::*member)(R))
      : name{R::method().name},
        carry_out{[member](Service& service, boost::json::object params, std::string) {
          return replied<R>(std::move(params),
                            [&service, member](R request) { return (service.*member)(std::move(request)); });
        }} {}
  template <rpc::Request R>
  Served(Reply<R> (Service::*member)(R, std::string))
      : name{R::method().name},
        carry_out{[member](Service& service, boost::json::object params, std::string by) {
          return replied<R>(std::move(params), [&service, member, by = std::move(by)](R request) {
            return (service.*member)(std::move(request), by);
          });
        }} {}

  std::string_view name;
  std::function<MethodReply(Service&, boost::json::object params, std::string by)> carry_out;
};

}  // namespace truepose::daemon
