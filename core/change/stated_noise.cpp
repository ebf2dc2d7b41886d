#include "core/change/stated_noise.hpp"

#include <algorithm>
#include <cmath>

#include "core/change/change_hypothesis.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kHalved = 0.5;  // of the standard deviation
constexpr double kQuarterMore = 1.25;
constexpr double kSeldom = 1000;  // is a noise that is up to a quarter more than stated

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

bool halves(double squares, Eigen::Index unknowns, const TimeEvidence& evidence) {
  const double all = evidence.r.squaredNorm(), left = std::max(0.0, all - squares);
  return left / static_cast<double>(evidence.degrees - unknowns) < kHalved * kHalved * all / evidence.degrees;
}

double chance_of(const ChangeEvidence& change, StatedNoise left, bool halved) {
  if (left == StatedNoise::Contradicts && !halved) return 1;
  if (left == StatedNoise::Explains) return change.chance(kStatedCounts);
  return (halved ? 1 : kSeldom) * change.chance(0);
}

}  // namespace truepose
