#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/math/dense_algebra.hpp"
#include "tools/experiment/point_cloud.hpp"
#include "tools/experiment/regression_methods.hpp"

namespace truepose {
namespace {

/// So many points carry a plane: enough for its 25 coefficients over a six-axis arm, and few enough that a
/// prediction takes as long over any number of poses.
constexpr int kSupport = 96;

struct SquaredDistance {
  int point;
  double squared;
};

/// The kSupport nearest of many points and the one after them, on the stack: gathered in a buffer of which
/// only these are left whenever it is full.
class NearestPoints {
 public:
  void insert(SquaredDistance next) {
    if (next.squared >= limit_) return;
    at_[size_++] = next;
    if (size_ == at_.size()) keep_nearest();
  }

  /// What was inserted, the nearest kSupport of it. To be called once.
  std::span<const SquaredDistance> support() {
    if (size_ > kSupport) keep_nearest();
    return {at_.data(), std::min<std::size_t>(size_, kSupport)};
  }
  /// Squared distance of the one after these, infinite where there is none.
  double edge() const { return limit_; }

 private:
  void keep_nearest() {
    const auto edge = at_.begin() + kSupport;
    std::nth_element(
        at_.begin(), edge, at_.begin() + static_cast<std::ptrdiff_t>(size_),
        [](const SquaredDistance& a, const SquaredDistance& b) { return a.squared < b.squared; });
    size_ = kSupport + 1;
    limit_ = edge->squared;
  }

  std::array<SquaredDistance, 3 * kSupport> at_;
  std::size_t size_ = 0;
  double limit_ = std::numeric_limits<double>::infinity();
};

/// The plane at z, y = c_0 + c' (z_i - z) / h, fitted to the points nearest to z; on the stack. A point
/// weighs as a Gaussian of its distance less what that is at the first one outside, so that the plane moves
/// without a jump where one point takes the place of another.
class LocalPlane {
 public:
  /// @param columns  the points of the cloud, one a column
  template <typename Keep>
  LocalPlane(const PointCloud& cloud, const Eigen::MatrixXd& columns, const Features& z, double bandwidth,
             Keep keep) {
    cloud.visit_distances(z, [&](int i, double squared) {
      if (keep(i)) near_.insert({i, squared});
    });
    support_ = near_.support();
    const double scale = -0.5 / (bandwidth * bandwidth);
    root_weight_.resize(static_cast<Eigen::Index>(support_.size()));
    for (Eigen::Index k = 0; k < root_weight_.size(); ++k) root_weight_[k] = scale * squared(k);
    root_weight_ = (root_weight_.exp() - std::exp(scale * near_.edge())).max(0).sqrt();

    rows_.resize(z.size() + 1, root_weight_.size());
    for (Eigen::Index k = 0; k < rows_.cols(); ++k) {
      rows_(0, k) = root_weight_[k];
      rows_.col(k).tail(z.size()) = (root_weight_[k] / bandwidth) * (columns.col(point(k)) - z);
    }
    N_.setZero(rows_.rows(), rows_.rows());
    add_outer_gram(rows_, N_);
  }
  LocalPlane(const LocalPlane&) = delete;

  /// Distance from z to the nearest point.
  double nearest() const {
    return std::sqrt(std::ranges::min(support_, {}, &SquaredDistance::squared).squared);
  }

  /// Adds `belief` times the plane's value at z, with a ridge, to `y`.
  void add_value(double ridge, double belief, const Eigen::MatrixXd& Y, Eigen::Ref<Eigen::VectorXd> y) const {
    Normal ridged = N_;
    ridged.diagonal().array() += ridge;
    // The value is linear in the targets: each counts by its row times the first column of the inverse.
    Coefficients first = Coefficients::Unit(N_.rows(), 0);
    solve_positive_in_place(ridged, first);
    for (Eigen::Index k = 0; k < rows_.cols(); ++k)
      y += (belief * root_weight_[k] * rows_.col(k).dot(first)) * Y.row(point(k)).transpose();
  }

 private:
  static constexpr int kMaxPlane = kMaxFeatures + 1;
  template <int kMaxRows, int kMaxCols>
  using Bounded = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows, kMaxCols>;
  using Normal = Bounded<kMaxPlane, kMaxPlane>;
  using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxPlane, 1>;

  int point(Eigen::Index k) const { return support_[static_cast<std::size_t>(k)].point; }
  double squared(Eigen::Index k) const { return support_[static_cast<std::size_t>(k)].squared; }

  NearestPoints near_;
  std::span<const SquaredDistance> support_;
  Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kSupport, 1> root_weight_;
  Bounded<kMaxPlane, kSupport> rows_;  ///< of the points, times the root of their weight, one a column
  Normal N_;                           ///< lower triangle
};

class MovingLeastSquares final : public Regressor {
 public:
  explicit MovingLeastSquares(RegressorState of)
      : Regressor{std::move(of)},
        cloud_{state().X},
        columns_{cloud_.Z().transpose()},
        bandwidth_{state().hyper.at("bandwidth")},
        ridge_{state().hyper.at("ridge")} {}

  void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
               Eigen::Ref<Eigen::VectorXd> y) const noexcept override {
    const LocalPlane plane{cloud_, columns_, cloud_.scaled(x), bandwidth_, [](int) { return true; }};
    y.setZero();
    plane.add_value(ridge_, cloud_.belief(plane.nearest()), state().Y, y);
  }

 private:
  PointCloud cloud_;
  Eigen::MatrixXd columns_;
  double bandwidth_, ridge_;
};

Hyper moving_least_squares_hyper(const RegressionData& data) {
  constexpr std::array kBandwidths{0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0};  // times sqrt(d / 6)
  constexpr std::array kRidges{1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0};
  const PointCloud cloud{data.X};
  const Eigen::MatrixXd columns = cloud.Z().transpose();
  const std::vector<int> groups = group_numbers(data.groups, data.X.rows());
  const double unit = std::sqrt(static_cast<double>(data.X.cols()) / 6);
  double smallest = std::numeric_limits<double>::infinity();
  Hyper best;
  for (const double bandwidth : kBandwidths) {
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(kRidges.size());
    for (Eigen::Index i = 0; i < data.X.rows(); ++i) {
      const auto elsewhere = [&](int j) {
        return groups[static_cast<std::size_t>(j)] != groups[static_cast<std::size_t>(i)];
      };
      const LocalPlane plane{cloud, columns, columns.col(i), bandwidth * unit, elsewhere};
      for (std::size_t r = 0; r < kRidges.size(); ++r) {
        Eigen::VectorXd y = Eigen::VectorXd::Zero(data.Y.cols());
        plane.add_value(kRidges[r], 1, data.Y, y);
        errors[static_cast<Eigen::Index>(r)] += (data.Y.row(i).transpose() - y).squaredNorm();
      }
    }
    Eigen::Index r = 0;
    if (errors.minCoeff(&r) >= smallest) continue;
    smallest = errors[r];
    best = {{"bandwidth", bandwidth * unit}, {"ridge", kRidges[static_cast<std::size_t>(r)]}};
  }
  return best;
}

}  // namespace

const RegressionMethod kMovingLeastSquares{
    .name = "mls",
    .fit = [](const RegressionData& data, int /*jobs*/) -> RegressorPtr {
      return std::make_shared<MovingLeastSquares>(
          RegressorState{data.X, data.Y, moving_least_squares_hyper(data)});
    },
    .refit = [](const Hyper& hyper, const RegressionData& data) -> RegressorPtr {
      return std::make_shared<MovingLeastSquares>(RegressorState{data.X, data.Y, hyper});
    }};

}  // namespace truepose
