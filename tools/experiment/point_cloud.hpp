#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "core/field/scaled_points.hpp"

namespace truepose {

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

}  // namespace truepose
