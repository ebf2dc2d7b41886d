#pragma once

#include <array>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/arm/spherical_wrist.hpp"

namespace truepose {

/// The two numbers by which a KRL position tells apart the joint positions that lead to its pose.
///
/// status (S): bit 0 is set where the wrist centre, seen from axis 1 at A1, lies behind it (x negative in the
/// base frame turned by A1); bit 1 where A3 is at or beyond the angle at which the wrist centre is in line
/// with axes 2 and 3 (A3 = 0 without an offset between axes 3 and 4); bit 2 where A5 <= 0. An upright arm
/// (A2 = -90, A3 = 90) has S = 2.
/// turn (T): bit i is set where axis i + 1 is negative.
/// Source: KUKA's KRL reference, status and turn of POS.
struct StatusTurn {
  int status = 0;
  int turn = 0;
};

inline constexpr int kStatusBits = 0b111;  ///< higher bits of S do not concern the axes
inline constexpr int kTurnBits = 0b111111;

/// Joint positions of a nominal six-axis arm from Cartesian positions as KRL gives them.
class StatusTurnInverse {
 public:
  /// @return the inverse, or one sentence on why the arm has none in closed form
  static std::expected<StatusTurnInverse, std::string> of(const RobotModel& nominal);
  /// Of an arm without a spherical wrist too: there the solutions are searched by Newton from many starts,
  /// and status, whose bits are defined by the wrist centre, does not count.
  /// @return the inverse, or one sentence on why the arm has none
  static std::expected<StatusTurnInverse, std::string> by_search(const RobotModel& nominal);
  bool searches() const { return !closed_form_; }

  /// Status and turn of joint positions. A bit whose axis stands on its boundary, up to rounding, is that of
  /// `given`, where there is one.
  StatusTurn of_joints(const JointVector& q, const std::optional<StatusTurn>& given = {}) const;

  /// Joint positions within the limits at X_BF.
  ///
  /// @param status, turn  where given, those of the result; on a boundary both of its sides count
  /// @param near          where status or turn are missing, the result is the nearest to these
  /// Errors: out of reach; no such solution within the limits; nothing tells the configuration.
  std::expected<JointVector, std::string> solve(const Eigen::Isometry3d& X_BF, std::optional<int> status,
                                                std::optional<int> turn,
                                                const std::optional<JointVector>& near) const;

 private:
  StatusTurnInverse(RobotModel nominal, std::optional<SphericalWristInverse> closed_form)
      : nominal_{std::move(nominal)}, closed_form_{std::move(closed_form)} {}
  std::vector<JointVector> all(const Eigen::Isometry3d& X_BF, const JointVector& reference) const;
  std::vector<JointVector> searched(const Eigen::Isometry3d& X_BF, const JointVector& reference) const;
  bool has_status(const JointVector& q, std::optional<int> status) const;

  /// What decides each bit of the status by its sign: positive where the bit is set. mm for bit 0, else rad.
  std::array<double, 3> status_measures(const JointVector& q) const;
  std::optional<JointVector> turned(JointVector q, std::optional<int> turn,
                                    const std::optional<JointVector>& near) const;

  RobotModel nominal_;
  std::optional<SphericalWristInverse> closed_form_;
};

}  // namespace truepose
