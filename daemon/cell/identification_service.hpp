#pragma once

#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "daemon/cell/model_service.hpp"
#include "daemon/cell/store_watch.hpp"
#include "proto/rpc/campaign.hpp"

namespace truepose::daemon {

/// Identifies the stored points of a campaign again, also of one that was aborted or has failed. The result
/// is a campaign of its own, with a document and a model. It names the campaign that measured the points.
class IdentificationService {
 public:
  IdentificationService(const CellParts& parts, CellRunner& runner, StoreWatch& store, ModelService& models)
      : parts_{parts}, runner_{runner}, store_{store}, models_{models} {}

  static std::vector<Served<IdentificationService>> methods() { return {&IdentificationService::identify}; }

 private:
  struct Request {
    rpc::CampaignIdentify asked;
    config::CellConfig config;  ///< the cell's, with the options that were asked for
  };
  /// What there is to identify from.
  struct Source {
    CampaignRecord record;
    std::vector<StoredPoint> points;
    std::vector<Resumption> resumptions;
  };
  struct Made {
    CampaignResult result;
    std::optional<std::vector<int>> validate;  ///< where the poses that validate were drawn
  };

  Reply<rpc::CampaignIdentify> identify(rpc::CampaignIdentify asked, std::string by);

  boost::asio::awaitable<std::expected<Source, control::RpcError>> read(std::string id);
  static std::expected<Made, std::string> make(const drivers::Clock& clock, Request request, Source source);
  Reply<rpc::CampaignIdentify> keep(Request request, CampaignRecord source, Made made, std::string by);

  CellParts parts_;
  CellRunner& runner_;
  StoreWatch& store_;
  ModelService& models_;
  bool busy_ = false;
};

}  // namespace truepose::daemon
