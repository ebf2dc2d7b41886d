#pragma once

#include <boost/json/object.hpp>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "daemon/cell/model_service.hpp"
#include "daemon/cell/store_watch.hpp"

namespace truepose::daemon {

/// Identifies the stored points of a campaign again, also of one that was aborted or has failed. The result
/// is a campaign of its own, with a document and a model. It names the campaign that measured the points.
class IdentificationService {
 public:
  IdentificationService(const CellParts& parts, CellRunner& runner, StoreWatch& store, ModelService& models)
      : parts_{parts}, runner_{runner}, store_{store}, models_{models} {}

  static std::vector<Method<IdentificationService>> methods();

 private:
  struct Request {
    std::string id;
    config::CellConfig config;    ///< the cell's, with the options that were asked for
    std::optional<double> split;  ///< share of the poses that identify
    bool activate = false;
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

  MethodReply identify(boost::json::object params, std::string by);

  std::expected<Request, control::RpcError> request(const boost::json::object& params) const;
  boost::asio::awaitable<std::expected<Source, control::RpcError>> read(std::string id);
  static std::expected<Made, std::string> make(Request request, Source source);
  MethodReply keep(Request request, CampaignRecord source, Made made, std::string by);

  CellParts parts_;
  CellRunner& runner_;
  StoreWatch& store_;
  ModelService& models_;
  bool busy_ = false;
};

}  // namespace truepose::daemon
