#pragma once

#include <boost/json/object.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "proto/rpc/campaign.hpp"
#include "proto/rpc/report.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/rpc_client.hpp"

namespace truepose::tools {

/// Where campaigns are read from that are over: a daemon, or the file that its store is, or a copy of that.
class CampaignSource {
 public:
  virtual ~CampaignSource() = default;
  // All throw CommandError.
  virtual Received<rpc::CampaignList::Result> ask(const rpc::CampaignList& request) = 0;
  virtual Received<rpc::CampaignGet::Result> ask(const rpc::CampaignGet& request) = 0;
  virtual rpc::CampaignExport::Result ask(const rpc::CampaignExport& request) = 0;
  virtual rpc::ReportGet::Result ask(const rpc::ReportGet& request) = 0;
};

/// A file in place of a daemon; empty: there is a daemon.
struct StoreFile {
  std::filesystem::path store;
  /// The arm, where no model of the store says which of its joints turn.
  std::filesystem::path robot;
};

/// An id as requests have it: left out where it is empty.
std::optional<std::string> unless_empty(const std::string& id);

/// The calibration document of a campaign with all its points, page by page. Throws CommandError.
///
/// @param id  empty: the newest that has one
boost::json::object whole_report(CampaignSource& source, const std::string& id);

/// Throws CommandError where the daemon cannot be reached, or the file cannot be read.
std::unique_ptr<CampaignSource> campaign_source(const OnlineOptions& online, const StoreFile& file);

}  // namespace truepose::tools
