#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

/// Where campaigns are read from that are over: a daemon, or the file that its store is, or a copy of that.
class CampaignSource {
 public:
  virtual ~CampaignSource() = default;
  /// Answers campaign.list, campaign.get, campaign.export and report.get as the control protocol describes
  /// them. Throws CommandError.
  virtual boost::json::value ask(const std::string& method, const boost::json::object& params) = 0;
};

/// A file in place of a daemon; empty: there is a daemon.
struct StoreFile {
  std::filesystem::path store;
  /// The arm, where no model of the store says which of its joints turn.
  std::filesystem::path robot;
};

/// The calibration document of a campaign with all its points, page by page. Throws CommandError.
///
/// @param id  empty: the newest that has one
boost::json::object whole_report(CampaignSource& source, const std::string& id);

/// Throws CommandError where the daemon cannot be reached, or the file cannot be read.
std::unique_ptr<CampaignSource> campaign_source(const OnlineOptions& online, const StoreFile& file);

}  // namespace truepose::tools
