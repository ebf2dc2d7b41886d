#pragma once

#include <boost/json/fwd.hpp>
#include <filesystem>
#include <string>

#include "proto/rpc/campaign.hpp"
#include "proto/rpc/drift.hpp"
#include "tools/truepose/command_line.hpp"
#include "tools/truepose/online/daemon_connection.hpp"

namespace truepose::tools {

/// Which daemon, and how to print. With `json`, standard output carries one JSON document and nothing else.
struct OnlineOptions : DaemonAddress {
  bool json = false;
};

/// The commands that talk to the daemon, and the options that say to which.
CommandLine online_commands();

/// "campaign pause" for the method "campaign.pause"; empty for one that no command calls.
std::string command_calling(const std::string& method);

/// Prints, at once.
void print(const std::string& text);
/// The answer as JSON where that was asked for, else as text.
void print(const OnlineOptions& online, const boost::json::value& answer, const std::string& text);

/// Lets the daemon measure a few poses and judge its active model. @return kFailed where that is no longer
/// right. Throws CommandError.
int check_drift(const OnlineOptions& online, const rpc::DriftCheck& request);

/// What a report is made of and where it goes. Empty paths are not read or written.
struct ReportOptions {
  std::string campaign;            ///< id; empty: the newest that is done
  std::filesystem::path store;     ///< a store's file instead of the daemon
  std::filesystem::path document;  ///< a calibration document on a file instead of the daemon's
  std::filesystem::path truth;     ///< the true simulated arm, to compare with the identified one
  std::filesystem::path path;      ///< the measured path of a production program (CSV), to be judged with it
  std::filesystem::path robot, model;    ///< by which the path alone is judged, without a campaign
  std::filesystem::path iso9283, frame;  ///< documents that the page gets sections of
  std::filesystem::path html, json;      ///< files to write
};

/// Reports a campaign: prints the table of errors (with `--json` the whole document) and writes the files
/// asked for. The document is that of `calibrate --json` with what was measured again and, where it runs, the
/// state of the stream. Throws CommandError: kFailed where a test of the verdict failed, or a production
/// program came no nearer by the correction.
int report_campaign(const OnlineOptions& online, const ReportOptions& options);

}  // namespace truepose::tools
