#include "core/field/point_cloud.hpp"

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

FeatureScale::FeatureScale(const Eigen::MatrixXd& X) : mean_{X.colwise().mean().transpose()} {
  const Eigen::VectorXd spread =
      ((X.rowwise() - mean_.transpose()).colwise().squaredNorm() / static_cast<double>(X.rows())).cwiseSqrt();
  const Eigen::VectorXd smallest = 1e-12 * (mean_.cwiseAbs().array() + 1).matrix();
  inverse_spread_ = (spread.array() > smallest.array()).select(spread.cwiseInverse(), 0.0);
}

Eigen::MatrixXd FeatureScale::apply_all(const Eigen::MatrixXd& X) const {
  return (X.rowwise() - mean_.transpose()) * inverse_spread_.asDiagonal();
}

Eigen::VectorXd target_scale(const Eigen::MatrixXd& Y) {
  const Eigen::VectorXd rms = (Y.colwise().squaredNorm() / static_cast<double>(Y.rows())).cwiseSqrt();
  return (rms.array() > 0).select(rms, 1.0);
}

BlockedPoints::BlockedPoints(const Eigen::MatrixXd& Z) {
  const Eigen::Index rows = (Z.rows() + kBlock - 1) / kBlock * kBlock;
  Z_ = Eigen::MatrixXd::Constant(rows, Z.cols(), 1e100);
  Z_.topRows(Z.rows()) = Z;
}

PointCloud::PointCloud(const Eigen::MatrixXd& X) : scale_{X}, Z_{scale_.apply_all(X)}, points_{Z_} {
  spacing_ = typical_spacing(*this, points_);
}

double PointCloud::belief(double distance) const {
  const double beyond = std::max(0.0, distance / spacing_ - 1);
  return std::exp(-0.5 * beyond * beyond);
}

std::vector<int> group_numbers(const std::vector<int>& groups, Eigen::Index points) {
  std::vector<int> numbers(static_cast<std::size_t>(points));
  if (groups.empty()) {
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
  }
  std::vector<int> distinct = groups;
  std::ranges::sort(distinct);
  distinct.erase(std::ranges::unique(distinct).begin(), distinct.end());
  std::ranges::transform(groups, numbers.begin(), [&](int group) {
    return static_cast<int>(std::ranges::lower_bound(distinct, group) - distinct.begin());
  });
  return numbers;
}

}  // namespace truepose
