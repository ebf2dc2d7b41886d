#pragma once

#include "core/calibration/calibrated_cell.hpp"
#include "core/kernels/flange_poses.hpp"

namespace truepose {

/// CalibratedCell::predict() of one cell at many joint positions, by the kernels. Keeps a reference to the
/// cell, which does not change meanwhile.
class CellPredictions {
 public:
  explicit CellPredictions(const CalibratedCell& cell)
      : cell_{cell}, flange_{cell.robot}, X_WB_{cell.base.isometry()} {}

  /// p_WS, mm.
  Eigen::Vector3d at(const JointVector& q, int smr, Approach approach = {}) const {
    return X_WB_ * (flange_.at(q, approach) * cell_.reflectors[static_cast<std::size_t>(smr)].p_FS_mm);
  }

 private:
  const CalibratedCell& cell_;
  FlangePoses flange_;
  Eigen::Isometry3d X_WB_;
};

}  // namespace truepose
