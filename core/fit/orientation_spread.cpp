#include "core/fit/orientation_spread.hpp"

#include <algorithm>
#include <cmath>

#include "core/math/dense_algebra.hpp"

namespace truepose {

OrientationSpread orientation_spread(std::span<const Eigen::Matrix3d> turns) {
  const auto count = static_cast<double>(turns.size());
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero(), spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Matrix3d& R : turns) mean += R / count;
  for (const Eigen::Matrix3d& R : turns) spread += (R - mean).transpose() * (R - mean) / count;
  const Svd svd = thin_svd(spread);
  return {svd.V.col(2), std::asin(std::min(1.0, std::sqrt(std::max(0.0, svd.s[2]))))};
}

}  // namespace truepose
