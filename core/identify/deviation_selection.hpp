#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/arm/joint_deviation.hpp"
#include "core/identify/least_squares_problem.hpp"

namespace truepose {

/// Terms that stand or fall together: "joint2.harmonic1" (sine and cosine), "joint2.gravity",
/// "joint2.approach", "joint1.scale".
struct DeviationGroup {
  std::string name;
  std::vector<DeviationTerm> terms;  ///< coefficients 0
};

/// Every group that the points could tell: harmonics of the given orders for revolute joints; gravity by the
/// robot's masses, or where these are not known by unit weights at the origins of its links; approach where
/// it was recorded and varies; scale for prismatic joints.
std::vector<DeviationGroup> deviation_groups(const RobotModel& robot, std::span<const Measurement> points,
                                             std::span<const int> harmonics);

/// What one group bought.
struct DeviationGain {
  std::string name;
  bool chosen = false;
  double rms_mm =
      0;  ///< cross-validated error with this group added to (chosen: taken from) the chosen model
};

struct DeviationChoice {
  std::vector<DeviationTerm> terms;  ///< coefficients 0; empty: geometry alone predicts best
  double scale = 0;                  ///< prior standard deviation of the coefficients that predicts best
  double geometric_rms_mm = 0;       ///< cross-validated error without any term, whitened
  double rms_mm = 0;                 ///< and with the chosen ones
  std::vector<DeviationGain> gains;  ///< of every group
};

/// Chooses the groups whose addition lowers the error at poses that the fit has not seen, by forward
/// selection under cross-validation (all points of a pose are left out together), about the geometric
/// solution, in which the problem is linear. A group is added only if its gain is beyond what chance gives.
///
/// @param geometric  cell at the solution without deviations
/// @param problem    that it solves
DeviationChoice choose_deviation(const CalibratedCell& geometric, const LeastSquaresProblem& problem,
                                 std::span<const DeviationGroup> groups);

}  // namespace truepose
