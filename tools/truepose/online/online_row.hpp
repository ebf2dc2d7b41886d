#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/truepose/online/campaign_commands.hpp"
#include "tools/truepose/online/campaign_source.hpp"
#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

namespace json = boost::json;

/// Everything that options are read into.
struct OnlineArguments {
  OnlineOptions online;
  std::string id;
  std::filesystem::path out;
  // campaign start
  std::string kind = "calibration";
  std::filesystem::path targets;
  std::optional<int> rounds, readings, cycles, identify_poses, validate_poses;
  std::optional<double> tolerance_mm;
  std::optional<bool> variation, remeasure;
  std::optional<std::int64_t> seed;
  bool uncompensated = false, no_activate = false, watch = false;
  std::optional<int> tool, base, touch, tool_poses;
  std::vector<std::string> points;
  std::filesystem::path points_file;
  std::vector<double> at, nominal, facing, orientation;
  bool together = false;
  std::string note;
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
  std::string method, params;
  std::optional<int> lease_s, limit;
  ReportOptions report;
};

/// A command that the daemon answers: it calls the method with those of its options that are parameters of
/// it, and prints the answer.
struct OnlineRow {
  std::string name, method, help;
  std::vector<Option> options{};
  std::string (*text)(const json::value& answer) = nullptr;
  int (*run)(const OnlineArguments& given, const json::object& params) = nullptr;  ///< where that is not all
};

/// Calls a method and prints the answer.
int ask(const OnlineOptions& online, const std::string& method, const json::object& params,
        std::string (*text)(const json::value&));

/// The parameter `id`.
Option id_option(OnlineArguments& arguments, const char* help, bool required = false);

/// Commands about campaigns.
std::vector<OnlineRow> campaign_rows(OnlineArguments& arguments);

}  // namespace truepose::tools
