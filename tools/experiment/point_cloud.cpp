#include "tools/experiment/point_cloud.hpp"

#include <cmath>
#include <numeric>

namespace truepose {
namespace {

/// Distances below this are the same pose measured again (another reflector, a repetition).
constexpr double kSamePose = 1e-6;

double typical_spacing(const PointCloud& cloud, const BlockedPoints& points) {
  std::vector<double> nearest;
  for (int i = 0; i < cloud.size(); ++i) {
    const Features z = cloud.Z().row(i);
    double smallest = std::numeric_limits<double>::infinity();
    for (int b = 0; b < points.blocks(); ++b) {
      const BlockedPoints::Block squared = points.squared_distances(z, b);
      smallest = std::min(smallest, (squared > kSamePose * kSamePose)
                                        .select(squared, std::numeric_limits<double>::infinity())
                                        .minCoeff());
    }
    if (smallest < 1e100) nearest.push_back(std::sqrt(smallest));
  }
  if (nearest.empty()) return 1;
  const auto quantile =
      nearest.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(nearest.size()));
  std::nth_element(nearest.begin(), quantile, nearest.end());
  return *quantile;
}

}  // namespace

PointCloud::PointCloud(const Eigen::MatrixXd& X) : scale_{X}, Z_{scale_.apply_all(X)}, points_{Z_} {
  spacing_ = typical_spacing(*this, points_);
}

double PointCloud::belief(double distance) const {
  const double beyond = std::max(0.0, distance / spacing_ - 1);
  return std::exp(-0.5 * beyond * beyond);
}

}  // namespace truepose
