#pragma once

#include <vector>

#include "daemon/cell/model_service.hpp"
#include "proto/rpc/targets.hpp"

namespace truepose::daemon {

/// Joints at which the real arm stands where the nominal one would.
class TargetService {
 public:
  TargetService(const CellParts& parts, ModelService& models) : parts_{parts}, models_{models} {}

  static std::vector<Served<TargetService>> methods() { return {&TargetService::compensate}; }

 private:
  Reply<rpc::TargetsCompensate> compensate(rpc::TargetsCompensate request);

  CellParts parts_;
  ModelService& models_;
};

using Joints = std::expected<std::vector<JointVector>, control::RpcError>;

/// Joints that a request gives in deg (mm for a prismatic joint). Error: which row has not as many as the
/// arm.
Joints joints_given(const std::vector<std::vector<double>>& rows, const RobotModel& nominal);
/// The joints of the nominal arm at poses of the flange; an error names the row.
Joints joints_at(const std::vector<rpc::PoseRow>& poses, const RobotModel& nominal);

}  // namespace truepose::daemon
