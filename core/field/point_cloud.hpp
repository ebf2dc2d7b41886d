#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

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

struct Neighbour {
  int point = 0;
  double distance = 0;
};

inline constexpr int kMaxNeighbours = 32;

/// The nearest points, in ascending order of distance, on the stack.
class Neighbours {
 public:
  explicit Neighbours(int wanted) : wanted_{wanted} {}
  double farthest() const {
    return size_ < wanted_ ? std::numeric_limits<double>::infinity()
                           : at_[static_cast<std::size_t>(size_) - 1].distance;
  }
  void insert(Neighbour next) {
    if (size_ < wanted_) ++size_;
    const auto last = at_.begin() + size_ - 1;
    const auto place = std::upper_bound(at_.begin(), last, next.distance,
                                        [](double d, const Neighbour& n) { return d < n.distance; });
    std::copy_backward(place, last, last + 1);
    *place = next;
  }
  std::span<const Neighbour> span() const { return {at_.data(), static_cast<std::size_t>(size_)}; }

 private:
  std::array<Neighbour, kMaxNeighbours> at_{};
  int wanted_;
  int size_ = 0;
};

/// Training points at unit spread, and how far around them a field fitted to them is to be believed.
class PointCloud {
 public:
  explicit PointCloud(const Eigen::MatrixXd& X);

  int size() const { return static_cast<int>(Z_.rows()); }
  const Eigen::MatrixXd& Z() const { return Z_; }
  Features scaled(const Eigen::Ref<const Eigen::VectorXd>& x) const { return scale_.apply(x); }

  /// Calls visit(point, squared distance from z) for every point, in their order.
  template <typename Visit>
  void visit_distances(const Features& z, Visit visit) const {
    for (int b = 0; b < points_.blocks(); ++b) {
      const BlockedPoints::Block squared = points_.squared_distances(z, b);
      const int begin = b * BlockedPoints::kBlock, end = std::min(size(), begin + BlockedPoints::kBlock);
      for (int i = begin; i < end; ++i) visit(i, squared[i - begin]);
    }
  }

  /// The `wanted` nearest points (at most kMaxNeighbours) among those that `keep` accepts.
  template <typename Keep>
  Neighbours nearest(const Features& z, int wanted, Keep keep) const {
    Neighbours found{wanted};
    visit_distances(z, [&](int i, double squared) {
      const double distance = std::sqrt(squared);
      if (distance < found.farthest() && keep(i)) found.insert({i, distance});
    });
    return found;
  }
  Neighbours nearest(const Features& z, int wanted) const {
    return nearest(z, wanted, [](int) { return true; });
  }

  /// 95 % of the points have another one within this distance.
  double spacing() const { return spacing_; }

  /// How much of a prediction to believe, by the distance to the nearest training point: all of it within the
  /// spacing of the points, and beyond it less and less, as a Gaussian whose sigma is that spacing.
  double belief(double distance) const;

 private:
  FeatureScale scale_;
  Eigen::MatrixXd Z_;
  BlockedPoints points_;
  double spacing_ = 0;
};

/// Numbers of the groups of N points: 0 .. G - 1 in ascending order of the groups' own. Empty = each its own.
std::vector<int> group_numbers(const std::vector<int>& groups, Eigen::Index points);

}  // namespace truepose
