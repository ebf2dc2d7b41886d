#pragma once

#include <Eigen/Core>
#include <chrono>
#include <optional>

namespace truepose::sim {

/// What the simulated tracker could see at one moment.
struct TargetSight {
  /// True centre of the SMR in the tracker's frame, mm; nothing while the beam cannot return from it (turned
  /// out of its acceptance cone, or hidden by the arm).
  std::optional<Eigen::Vector3d> p_WS_mm;
  bool moving = false;                          ///< the arm is not standing still
  std::chrono::steady_clock::time_point stamp;  ///< the moment this is true for
};

/// The one SMR that the simulated arm carries. Asked from the tracker's executor; must not block.
class SimulatedTarget {
 public:
  virtual ~SimulatedTarget() = default;
  virtual TargetSight look() const = 0;
};

}  // namespace truepose::sim
