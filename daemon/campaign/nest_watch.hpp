#pragma once

#include <Eigen/Core>
#include <vector>

#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

/// Measures the nests before the first pose of a campaign, after every so many poses, and when asked for.
class NestWatch {
 public:
  /// @param session  outlives it
  explicit NestWatch(MeasuringSession& session);

  /// To be asked after each pose.
  CampaignOutcome<void> after_pose();
  /// Does nothing where the cell has no nests. A nest that is not seen is reported; the campaign continues.
  CampaignOutcome<void> measure();

 private:
  MeasuringSession& session_;
  std::vector<Eigen::Vector3d> seen_mm_;  ///< where each was last; at first where the cell file says
  bool begun_ = false;
  int poses_since_ = 0;
};

}  // namespace truepose::daemon
