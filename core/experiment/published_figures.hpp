#pragma once

namespace truepose {

/// What the method's paper prints of its results, mm. Source: Liu, Yang, Zhang, Shi, Li, Li, Method for
/// improving robot positioning accuracy based on two-stage iterative compensation, doi
/// 10.7690/bgzdh.2026.05.019.
namespace published {

/// Mean position error of the simulated arm, 30 + 30 random points (section 3.1).
inline constexpr double kSimulatedLeastSquares_mm = 0.2951;
inline constexpr double kSimulatedTwoStage_mm = 0.1681;

/// Position errors of the real KR 210 R2700, 30 validation points (Table 4).
struct Stage {
  double max_mm, min_mm, mean_mm;
};
inline constexpr Stage kRealBefore{4.465, 1.139, 2.862};
inline constexpr Stage kRealGeometric{0.803, 0.533, 0.693};
inline constexpr Stage kRealResidual{0.756, 0.410, 0.571};

}  // namespace published
}  // namespace truepose
