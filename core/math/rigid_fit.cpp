#include "core/math/rigid_fit.hpp"

#include <cassert>
#include <numeric>

#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

Eigen::Vector3d centroid(std::span<const Eigen::Vector3d> points) {
  const Eigen::Vector3d sum = std::accumulate(points.begin(), points.end(), Eigen::Vector3d::Zero().eval());
  return sum / static_cast<double>(points.size());
}

}  // namespace

std::expected<Eigen::Isometry3d, std::string> rigid_fit(std::span<const Eigen::Vector3d> from,
                                                        std::span<const Eigen::Vector3d> to) {
  assert(from.size() == to.size());
  constexpr double kOnOneLine = 1e-6;  // of the extent of the points, across to along
  if (from.size() < 3) return std::unexpected("at least 3 points are needed to see a rotation");
  const Eigen::Vector3d from_centre = centroid(from), to_centre = centroid(to);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    scatter += (to[i] - to_centre) * (from[i] - from_centre).transpose();
  }
  const Svd svd = thin_svd(scatter);
  if (!(svd.s[1] > kOnOneLine * kOnOneLine * svd.s[0]))
    return std::unexpected("the points are on one line and do not show a rotation about it");
  const Eigen::Matrix3d U = svd.U, V = svd.V;
  const Eigen::Vector3d handed(1, 1, (U * V.transpose()).determinant() < 0 ? -1 : 1);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = U * handed.asDiagonal() * V.transpose();
  X.translation() = to_centre - X.linear() * from_centre;
  return X;
}

}  // namespace truepose
