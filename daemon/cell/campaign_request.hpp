#pragma once

#include <boost/json/object.hpp>
#include <expected>
#include <string>
#include <string_view>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign_result.hpp"
#include "daemon/cell/model_service.hpp"
#include "proto/control/param_reader.hpp"

namespace truepose::daemon {

/// A campaign that is asked for.
struct CampaignRequest {
  config::CellConfig config;  ///< the cell's, as it is for this campaign
  CampaignOrder order;
  bool activate = false;  ///< the model that it makes
  std::string note;
};
using AskedCampaign = std::expected<CampaignRequest, control::RpcError>;

/// Reads what clients ask for of campaigns. Errors: what is wrong with a parameter, and why there is no model
/// where the campaign needs one.
class CampaignRequests {
 public:
  CampaignRequests(const config::CellConfig& config, const CellRunner& runner, const ModelService& models)
      : config_{config}, runner_{runner}, models_{models} {}

  /// @param params  those of campaign.start
  AskedCampaign start(const boost::json::object& params) const;
  /// @param params  those of drift.check
  AskedCampaign drift_check(const boost::json::object& params) const;

 private:
  AskedCampaign of_kind(std::string_view kind, control::ParamReader& read) const;
  AskedCampaign calibration(control::ParamReader& read) const;
  AskedCampaign targets(control::ParamReader& read) const;
  AskedCampaign iso9283(control::ParamReader& read) const;
  AskedCampaign tool(control::ParamReader& read) const;
  AskedCampaign base(control::ParamReader& read) const;

  const config::CellConfig& config_;
  const CellRunner& runner_;
  const ModelService& models_;
};

}  // namespace truepose::daemon
