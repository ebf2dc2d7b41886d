#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace truepose::tools {

/// Which daemon, and how to print. With `json`, standard output carries one JSON document and nothing else.
struct OnlineOptions {
  std::string daemon;  ///< as connect_to_daemon() takes it
  std::filesystem::path token_file;
  bool json = false;
};

struct CampaignStartOptions {
  std::string kind = "calibration";
  std::filesystem::path targets;  ///< CSV: q1..qN or x,y,z,a,b,c; empty: validation poses of a plan
  std::optional<int> rounds, readings, cycles;
  std::optional<double> tolerance_mm;
  std::optional<bool> variation;
  bool uncompensated = false;
  std::optional<int> identify_poses, validate_poses;
  std::optional<std::int64_t> seed;
  std::optional<bool> remeasure;
  bool activate = true;
  bool watch = false;
};

/// Files to write what a campaign found to; empty: none.
struct CampaignFiles {
  std::filesystem::path joints;    ///< found for targets, as truepose fk and compensate read them
  std::filesystem::path cycles;    ///< of an ISO 9283 test, as truepose iso9283 reads them
  std::filesystem::path document;  ///< of a kind that is no calibration (JSON)
};

struct EventsOptions {
  std::vector<std::string> topics;     ///< empty: all
  std::optional<std::int64_t> after;   ///< number of the last event seen
  std::optional<std::uint64_t> count;  ///< end after so many; else never
};

/// Each command prints its result on standard output, or one line on standard error, and returns the exit
/// code.
int status(const OnlineOptions& online);
int connect_cell(const OnlineOptions& online);
int acknowledge_cell(const OnlineOptions& online);

int campaign_start(const OnlineOptions& online, const CampaignStartOptions& start);
/// @param action  "pause", "resume" or "abort"
int campaign_control(const OnlineOptions& online, const std::string& action);
int campaign_list(const OnlineOptions& online);
int campaign_show(const OnlineOptions& online, const std::string& id, const CampaignFiles& files);
/// Follows a campaign to its end; succeeds if it ends as done. An empty id means the newest.
int campaign_watch(const OnlineOptions& online, const std::string& id);

/// Lets the daemon measure a few poses and judge its active model; fails where that is no longer right.
int check_drift(const OnlineOptions& online);

int model_list(const OnlineOptions& online);
int model_show(const OnlineOptions& online, const std::string& id);
int model_activate(const OnlineOptions& online, const std::string& id);
int model_deactivate(const OnlineOptions& online);
/// Writes the model file, to standard output where `out` is empty.
int model_export(const OnlineOptions& online, const std::string& id, const std::filesystem::path& out);

/// @param action  "start", "stop" or "status"
int stream_control(const OnlineOptions& online, const std::string& action);

/// Prints events, one a line (with `json` one document a line).
int events(const OnlineOptions& online, const EventsOptions& options);
/// Calls any method; params is JSON text or empty. Prints the result as JSON.
int call_method(const OnlineOptions& online, const std::string& method, const std::string& params);

}  // namespace truepose::tools
