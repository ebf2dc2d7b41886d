#pragma once

#include <expected>
#include <string>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign_result.hpp"
#include "daemon/cell/model_service.hpp"
#include "proto/rpc/campaign.hpp"
#include "proto/rpc/drift.hpp"

namespace truepose::daemon {

/// A campaign that is asked for.
struct CampaignRequest {
  config::CellConfig config;  ///< the cell's, as it is for this campaign
  CampaignOrder order;
  bool activate = false;  ///< the model that it makes
  std::string note;
};
using AskedCampaign = std::expected<CampaignRequest, control::RpcError>;

/// Makes orders of what clients ask for of campaigns. Errors: what is wrong with a parameter, and why there
/// is no model where the campaign needs one.
class CampaignRequests {
 public:
  CampaignRequests(const config::CellConfig& config, const CellRunner& runner, const ModelService& models)
      : config_{config}, runner_{runner}, models_{models} {}

  AskedCampaign start(const rpc::CampaignStart& asked) const;
  AskedCampaign drift_check(const rpc::DriftCheck& asked) const;

 private:
  AskedCampaign of_kind(const rpc::CampaignStart& asked) const;
  AskedCampaign calibration(const rpc::CampaignStart& asked) const;
  AskedCampaign targets(const rpc::CampaignStart& asked) const;
  AskedCampaign iso9283(const rpc::CampaignStart& asked) const;
  AskedCampaign tool(const rpc::CampaignStart& asked) const;
  AskedCampaign base(const rpc::CampaignStart& asked) const;
  /// The cell's, with the seed that is asked for.
  config::CellConfig config_for(const auto& asked) const {
    config::CellConfig config = config_;
    config.campaign.seed = asked.seed.value_or(config.campaign.seed);
    return config;
  }

  const config::CellConfig& config_;
  const CellRunner& runner_;
  const ModelService& models_;
};

}  // namespace truepose::daemon
