#include "core/judge/chance_of_gain.hpp"

#include <algorithm>
#include <cmath>

#include "core/judge/drift_causes.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kHalved = 0.5;       // of the standard deviation
constexpr double kStatedCounts = 10;  // residuals: a stated noise is known to a quarter

/// Chance of a share of squares beyond `share` for `unknowns` columns beside twice `shape` others, by the
/// beta distribution; a little too large for an odd number of them.
double beta_tail(double share, double shape, Eigen::Index unknowns) {
  double term = 1, sum = 1;
  for (Eigen::Index i = 1; i < (unknowns + 1) / 2; ++i) {
    term *= share * (shape + static_cast<double>(i) - 1) / static_cast<double>(i);
    sum += term;
  }
  return std::pow(1 - share, shape) * sum;
}

}  // namespace

bool noise_explains(const TimeEvidence& evidence, const Eigen::VectorXd& left, Eigen::Index unknowns) {
  if (!evidence.noise_known) return false;
  double along2 = 0, degrees_along = 0;
  for (Eigen::Index row = 0; row < left.size(); row += 3) {
    const Eigen::Vector3d beam = evidence.beams.segment<3>(row);
    along2 += std::pow(beam.dot(left.segment<3>(row)), 2);
    degrees_along += 1 - (evidence.U.middleRows<3>(row).transpose() * beam).squaredNorm();
  }
  const double part_left = 1 - static_cast<double>(unknowns) / evidence.degrees;
  const auto fits = [=](double squares, double degrees) {
    return gamma_tail(squares / 2, part_left * degrees / 2) >= kSignificance;
  };
  return fits(along2, degrees_along) && fits(left.squaredNorm() - along2, evidence.degrees - degrees_along);
}

double squares_left(const Gain& gain, const TimeEvidence& evidence) {
  return std::max(0.0, evidence.r.squaredNorm() - gain.squares);
}

bool halves(const Gain& gain, const TimeEvidence& evidence) {
  return squares_left(gain, evidence) / static_cast<double>(evidence.degrees - gain.unknowns) <
         kHalved * kHalved * evidence.r.squaredNorm() / evidence.degrees;
}

double chance_of(const Gain& gain, const TimeEvidence& evidence) {
  if (!gain.as_stated && !halves(gain, evidence)) return 1;
  const double stated = gain.as_stated ? kStatedCounts : 0;
  const auto degrees_left = static_cast<double>(evidence.degrees - gain.unknowns);
  return beta_tail(gain.squares / (stated + squares_left(gain, evidence) + gain.squares),
                   (stated + degrees_left) / 2, gain.unknowns);
}

}  // namespace truepose
