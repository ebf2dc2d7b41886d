#include "core/change/chance_of_gain.hpp"

#include <algorithm>
#include <cmath>

#include "core/change/drift_causes.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kHalved = 0.5;  // of the standard deviation
constexpr double kQuarterMore = 1.25;
constexpr double kSeldom = 1000;  // is a noise that is up to a quarter more than stated

/// Probability of a share of squares above `share` for `unknowns` columns together with twice `shape` others,
/// by the beta distribution. A little too large for an odd number of columns.
double beta_tail(double share, double shape, Eigen::Index unknowns) {
  double term = 1, sum = 1;
  for (Eigen::Index i = 1; i < (unknowns + 1) / 2; ++i) {
    term *= share * (shape + static_cast<double>(i) - 1) / static_cast<double>(i);
    sum += term;
  }
  return std::pow(1 - share, shape) * sum;
}

}  // namespace

StatedNoise stated_noise(const TimeEvidence& evidence, const Eigen::VectorXd& left, Eigen::Index unknowns) {
  if (!evidence.noise_known) return StatedNoise::Contradicts;
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
  const auto explains = [&](double more) {
    const double along = along2 / (more * more), across = left.squaredNorm() / (more * more) - along;
    return fits(along, degrees_along) && fits(across, evidence.degrees - degrees_along);
  };
  if (explains(1)) return StatedNoise::Explains;
  return explains(kQuarterMore) ? StatedNoise::NearlyExplains : StatedNoise::Contradicts;
}

double squares_left(const Gain& gain, const TimeEvidence& evidence) {
  return std::max(0.0, evidence.r.squaredNorm() - gain.squares);
}

bool halves(const Gain& gain, const TimeEvidence& evidence) {
  return squares_left(gain, evidence) / static_cast<double>(evidence.degrees - gain.unknowns) <
         kHalved * kHalved * evidence.r.squaredNorm() / evidence.degrees;
}

double chance_of(const Gain& gain, const TimeEvidence& evidence) {
  const bool as_stated = gain.noise == StatedNoise::Explains, halved = halves(gain, evidence);
  if (gain.noise == StatedNoise::Contradicts && !halved) return 1;
  const double stated = as_stated ? kStatedCounts : 0, rarer = as_stated || halved ? 1 : kSeldom;
  const auto degrees_left = static_cast<double>(evidence.degrees - gain.unknowns);
  return rarer * beta_tail(gain.squares / (stated + squares_left(gain, evidence) + gain.squares),
                           (stated + degrees_left) / 2, gain.unknowns);
}

}  // namespace truepose
