#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/compensate/target_compensation.hpp"
#include "core/data/calibrated_cell.hpp"

namespace truepose {

struct TrackerLoopOptions {
  int rounds = 15;              ///< at most
  double tolerance_mm = 0.003;  ///< of the averaged error, see TrackerLoop
};

enum class TrackerLoopEnd {
  Reached,      ///< the averaged error is within the tolerance
  DoesNotFall,  ///< in three rounds, one after the other, it was no smaller than at first
  RoundsUsed,
  OutOfReach,  ///< the arm cannot correct it: a joint limit, or farther off than an arm is wrong
};

/// "reached", "does_not_fall", "rounds_used", "out_of_reach"
std::string_view name_of(TrackerLoopEnd end);

/// Tracker in the loop at one target: measures where the arm stands, corrects its joints, measures again.
///
/// Round k corrects a share 1/k of its error e_k. That makes the correction the mean of all readings, so
/// that noise and repeatability of a single one are not followed to the end, and e_k / k what the mean of k
/// readings still misses: the averaged error, by which the loop is judged. Once the arm itself is corrected,
/// e_k stays at the noise and the averaged error falls as 1/k.
class TrackerLoop {
 public:
  /// @param cell     how joints move the reflector; its first one is measured
  /// @param p_WS_mm  where the reflector should be, tracker frame
  /// @param q        joints to begin with; the corrected ones are those nearest to them
  TrackerLoop(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm, const JointVector& q,
              const TrackerLoopOptions& options = {});

  /// Joints to command for the next reading; once the loop has ended, those that it found.
  const JointVector& q() const { return q_; }
  /// Takes the reading of the arm at q(), while the loop has not ended.
  void add(const Eigen::Vector3d& p_WS_mm);

  std::optional<TrackerLoopEnd> end() const { return end_; }
  const std::vector<double>& errors_mm() const { return errors_mm_; }  ///< measured, of each round
  double averaged_error_mm() const;                                    ///< after the last round

 private:
  void correct(const Eigen::Vector3d& missing_W);
  void judge();

  TargetCompensation arm_;
  Eigen::Matrix3d R_BW_;
  Eigen::Vector3d p_FS_mm_, wanted_W_mm_;
  Eigen::Vector3d aim_B_mm_;  // where the cell's own arm would be sent
  TrackerLoopOptions options_;
  JointVector q_, q_first_, q_best_;  // best: of the least error
  std::vector<double> errors_mm_;
  int no_better_ = 0;  // rounds, up to the last, that were no better than the first
  std::optional<TrackerLoopEnd> end_;
};

}  // namespace truepose
