#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/truepose/online/campaign_commands.hpp"
#include "tools/truepose/online/campaign_source.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/rpc_client.hpp"

namespace truepose::tools {

namespace json = boost::json;

/// Everything that options are read into.
struct OnlineArguments {
  OnlineOptions online;
  std::string id;
  std::filesystem::path out;
  // campaign start
  rpc::CampaignStart start{.rounds = {}, .tolerance_mm = {}, .poses_per_point = {}};
  std::filesystem::path targets;
  bool uncompensated = false, no_activate = false, watch = false;
  std::optional<int> tool, base;
  std::filesystem::path points_file;
  std::vector<double> at, nominal, facing, orientation;
  std::optional<std::int64_t> seed;
  // campaign identify
  std::string non_geometric, residual, loss, prior;
  std::vector<int> harmonics;
  std::optional<bool> correct_by_nests;
  std::optional<double> split;
  bool activate = false;
  // the others
  CampaignFiles files;
  StoreFile store;
  std::vector<std::string> topics;
  std::optional<std::int64_t> after;
  std::optional<std::uint64_t> count;
  std::optional<double> timeout_s;  ///< of an event; none: it may take any time
  std::string method, params;
  std::optional<int> lease_s, limit;
  ReportOptions report;
};

/// A command that the daemon answers.
struct OnlineRow {
  std::string name, method, help;
  std::vector<Option> options{};
  /// @param params  those of the options that are parameters of the method
  std::function<int(const OnlineArguments& given, const json::object& params)> run{};
  std::vector<Example> examples{};
};

/// Calls a method and prints the answer.
/// @param params  those that are left out have the daemon's defaults
template <rpc::Request R>
int ask(const OnlineOptions& online, const json::object& params,
        std::string (*text)(const typename R::Result&)) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  constexpr auto read = &received<typename R::Result>;
  const json::value answer = value_or_throw(client.call(R::method().name, params));
  // As JSON, what a daemon of another version answers is printed too.
  print(online, answer, online.json ? "" : text(value_or_throw(read(answer, R::method().name)).record));
  return kDone;
}

/// A command that is no more than that.
template <rpc::Request R>
OnlineRow asks(std::string name, std::string help, std::vector<Option> options,
               std::string (*text)(const typename R::Result&), std::vector<Example> examples = {}) {
  return {std::move(name),
          std::string{R::method().name},
          std::move(help),
          std::move(options),
          [text](const OnlineArguments& given, const json::object& params) {
            return ask<R>(given.online, params, text);
          },
          std::move(examples)};
}

/// The parameter `id`.
/// @param of  "campaign", "model"
Option id_option(OnlineArguments& arguments, const char* of, const char* help, bool required = false);

/// Commands about campaigns.
std::vector<OnlineRow> campaign_rows(OnlineArguments& arguments);

}  // namespace truepose::tools
