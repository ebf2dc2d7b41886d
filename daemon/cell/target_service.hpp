#pragma once

#include <vector>

#include "daemon/cell/model_service.hpp"

namespace truepose::daemon {

/// Joints at which the real arm stands where the nominal one would.
class TargetService {
 public:
  TargetService(const CellParts& parts, ModelService& models) : parts_{parts}, models_{models} {}

  static std::vector<Method<TargetService>> methods() {
    return {{"targets.compensate", &TargetService::compensate}};
  }

 private:
  MethodReply compensate(boost::json::object params);

  CellParts parts_;
  ModelService& models_;
};

/// The joints of the nominal arm at poses of the flange (mm, KUKA's angles in deg); an error names the row.
std::expected<std::vector<JointVector>, control::RpcError> joints_at(
    const std::vector<std::vector<double>>& poses, const RobotModel& nominal);

}  // namespace truepose::daemon
