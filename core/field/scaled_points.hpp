#pragma once

#include <Eigen/Core>

#include "core/field/regressor.hpp"

namespace truepose {

/// Features of one pose, on the stack.
using Features = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxFeatures, 1>;

/// Shifts features to zero mean and scales them to unit spread; one that does not vary becomes zero.
class FeatureScale {
 public:
  explicit FeatureScale(const Eigen::MatrixXd& X);
  Features apply(const Eigen::Ref<const Eigen::VectorXd>& x) const {
    return (x - mean_).cwiseProduct(inverse_spread_);
  }
  Eigen::MatrixXd apply_all(const Eigen::MatrixXd& X) const;

 private:
  Eigen::VectorXd mean_, inverse_spread_;
};

/// Root mean square of each target, 1 for one that is always zero. Targets are not centred: zero is what a
/// residual field says where it knows nothing.
Eigen::VectorXd target_scale(const Eigen::MatrixXd& Y);

/// Points stored so that distances to many of them are computed at once, in blocks.
class BlockedPoints {
 public:
  static constexpr int kBlock = 32;
  using Block = Eigen::Array<double, kBlock, 1>;

  explicit BlockedPoints(const Eigen::MatrixXd& Z);
  int blocks() const { return static_cast<int>(Z_.rows()) / kBlock; }

  /// Squared distances from `z` to the points of a block. Beyond the last point, they are huge.
  Block squared_distances(const Features& z, int block) const {
    Block sum = Block::Zero();
    for (Eigen::Index k = 0; k < z.size(); ++k)
      sum += (Z_.col(k).segment<kBlock>(block * kBlock).array() - z[k]).square();
    return sum;
  }

 private:
  Eigen::MatrixXd Z_;
};

}  // namespace truepose
