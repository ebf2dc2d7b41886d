#include "core/compensate/correction_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace truepose {
namespace {

constexpr double kLargestGridPoint = 9007199254740992.0;  // 2^53: beyond it doubles skip whole numbers
constexpr double kRounding = 1e-6;                        // of a grid step: forgives 19999.9999999 for 20000

bool on_grid(double value, double resolution) { return std::abs(value) / resolution < kLargestGridPoint; }

bool usable(const JointVector& wanted, const CorrectionRange& in_effect, const JointVector& commanded,
            const CorrectionBounds& bounds) {
  const Eigen::Index axes = in_effect.min.size();
  const auto finite = [&](const JointVector& edge) {
    return std::all_of(edge.begin(), edge.end(), [&](double x) { return on_grid(x, bounds.resolution); });
  };
  return wanted.size() == axes && in_effect.max.size() == axes && commanded.size() == axes &&
         bounds.min.size() == axes && bounds.max.size() == axes && wanted.allFinite() &&
         commanded.allFinite() && !bounds.min.hasNaN() && !bounds.max.hasNaN() && bounds.max_step >= 0 &&
         bounds.max_total >= 0 && bounds.resolution > 0 && std::isfinite(bounds.resolution) &&
         on_grid(bounds.max_step, bounds.resolution) && on_grid(bounds.max_total, bounds.resolution) &&
         std::isfinite(bounds.limit_margin) && finite(in_effect.min) && finite(in_effect.max);
}

/// Halfway, on the grid.
JointVector middle(const CorrectionRange& range, double resolution) {
  JointVector result = range.min;
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    if (range.min[i] == range.max[i]) continue;
    result[i] = std::nearbyint((range.min[i] + range.max[i]) / 2 / resolution) * resolution;
  }
  return result;
}

}  // namespace

BoundedCorrection bound_correction(const JointVector& wanted, const CorrectionRange& in_effect,
                                   const JointVector& commanded, const CorrectionBounds& bounds) noexcept {
  BoundedCorrection result;
  if (!usable(wanted, in_effect, commanded, bounds)) {
    result.clamps.not_finite = true;
    const bool finite = in_effect.min.size() == in_effect.max.size() && in_effect.min.allFinite() &&
                        in_effect.max.allFinite();
    result.correction = finite ? middle(in_effect, CorrectionBounds{}.resolution)
                               : JointVector{JointVector::Zero(in_effect.min.size())};
    return result;
  }
  result.correction = middle(in_effect, bounds.resolution);

  const double largest = wanted.cwiseAbs().maxCoeff();
  result.clamps.total = largest > bounds.max_total;
  const double part = result.clamps.total ? bounds.max_total / largest : 1;

  // The rest is counted in steps of the wire's grid, where a sum is exact: ramps end at exactly zero.
  const double max_steps = std::floor(bounds.max_step / bounds.resolution + kRounding);
  for (Eigen::Index i = 0; i < wanted.size(); ++i) {
    const double within_total = part * wanted[i];
    const double lowest = std::min(0.0, bounds.min[i] + bounds.limit_margin - commanded[i]);
    const double highest = std::max(0.0, bounds.max[i] - bounds.limit_margin - commanded[i]);
    const double within_limits = std::clamp(within_total, lowest, highest);
    const double to = std::trunc(within_limits / bounds.resolution + std::copysign(kRounding, within_limits));
    const double down_to = std::ceil(in_effect.max[i] / bounds.resolution - kRounding) - max_steps;
    const double up_to = std::floor(in_effect.min[i] / bounds.resolution + kRounding) + max_steps;

    result.clamps.limit |= within_limits != within_total;
    if (down_to > up_to) {
      result.clamps.step = true;
      continue;
    }
    const double sent = std::clamp(to, down_to, up_to);
    result.clamps.step |= sent != to;
    result.correction[i] = sent * bounds.resolution;
  }
  return result;
}

}  // namespace truepose
