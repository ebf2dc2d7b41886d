#pragma once

#include <filesystem>
#include <string>

#include "tools/truepose/online/campaign_source.hpp"
#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

// The commands about campaigns that are more than a call and its text. All throw CommandError, and
// ConfigError for files; all return the exit code.

/// Files to write what a campaign found to; empty: none.
struct CampaignFiles {
  std::filesystem::path joints;    ///< found for targets, as truepose fk and compensate read them
  std::filesystem::path cycles;    ///< of an ISO 9283 test, as truepose iso9283 reads them
  std::filesystem::path frame;     ///< a tool or base that was measured, as truepose tool --out writes it
  std::filesystem::path document;  ///< of every kind (JSON)
  /// Points to identify and to validate from, as truepose calibrate reads them; of a tool as truepose tool
  /// does.
  std::filesystem::path data;
};

/// Targets of a campaign from CSV: joints of q1..qN, or poses of x,y,z,a,b,c.
void add_targets(const std::filesystem::path& file, rpc::CampaignStart& request);

/// Points of a tool or a fixture from CSV (point; x,y,z: where it is, roughly; px,py,pz: its coordinates in
/// the frame, where known).
void add_points(const std::filesystem::path& file, rpc::CampaignStart& request);

/// Starts a campaign and follows it to its end; of one that is no calibration, shows what it found.
int start_and_watch(const OnlineOptions& online, const rpc::CampaignStart& request);
/// Goes on with a campaign and follows it to its end.
/// @param id  of one that was interrupted; empty: the one that is paused
int resume_and_watch(const OnlineOptions& online, const std::string& id);
/// Follows a campaign to its end; succeeds if it ends as done.
/// @param id  empty: the newest
int watch_campaign(const OnlineOptions& online, const std::string& id);
int list_campaigns(const OnlineOptions& online, const StoreFile& store);
/// Shows a campaign, and writes what it found to files.
/// @param id  empty: the newest
int show_campaign(const OnlineOptions& online, const StoreFile& store, const std::string& id,
                  const CampaignFiles& files);
/// The same with at least one file; prints only that they were written.
int export_campaign(const OnlineOptions& online, const StoreFile& store, const std::string& id,
                    const CampaignFiles& files);

}  // namespace truepose::tools
