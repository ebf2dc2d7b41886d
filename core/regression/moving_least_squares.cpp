#include "core/regression/moving_least_squares.hpp"

#include <Eigen/Cholesky>

#include "core/regression/point_cloud.hpp"

namespace truepose {
namespace {

constexpr int kMaxPlane = kMaxFeatures + 1;

/// Normal equations of the plane at z, y = c_0 + c' (z_i - z) / h, on the stack.
class LocalPlane {
 public:
  template <typename Keep>
  LocalPlane(const Eigen::MatrixXd& Z, const Eigen::MatrixXd& Y, const Features& z, double bandwidth,
             Keep keep)
      : N_{Normal::Zero(Z.cols() + 1, Z.cols() + 1)}, b_{Right::Zero(Z.cols() + 1, Y.cols())} {
    Row row(Z.cols() + 1);
    row[0] = 1;
    for (Eigen::Index i = 0; i < Z.rows(); ++i) {
      row.tail(Z.cols()) = (Z.row(i).transpose() - z) / bandwidth;
      const double squared = row.tail(Z.cols()).squaredNorm();
      nearest_ = std::min(nearest_, std::sqrt(squared) * bandwidth);
      if (squared > kNegligible || !keep(i)) continue;
      const double weight = std::exp(-0.5 * squared);
      for (Eigen::Index k = 0; k < row.size(); ++k)
        N_.col(k).tail(row.size() - k) += weight * row[k] * row.tail(row.size() - k);
      for (Eigen::Index j = 0; j < Y.cols(); ++j) b_.col(j) += weight * Y(i, j) * row;
    }
  }

  /// Distance from z to the nearest point.
  double nearest() const { return nearest_; }

  /// Adds `belief` times the plane's value at z, with a ridge, to `y`.
  void add_value(double ridge, double belief, Eigen::Ref<Eigen::VectorXd> y) const {
    Normal ridged = N_;
    ridged.diagonal().array() += ridge;
    Row unit = Row::Unit(N_.rows(), 0);
    Eigen::LLT<Eigen::Ref<Normal>> factor{ridged};
    factor.solveInPlace(unit);
    for (Eigen::Index j = 0; j < y.size(); ++j) y[j] += belief * unit.dot(b_.col(j));
  }

 private:
  using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxPlane, kMaxPlane>;
  using Right =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxPlane, kMaxTargets>;
  using Row = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxPlane, 1>;
  /// A weight below exp(-15) = 3e-7 changes nothing.
  static constexpr double kNegligible = 30;

  Normal N_;  ///< lower triangle
  Right b_;
  double nearest_ = std::numeric_limits<double>::infinity();
};

class MovingLeastSquares final : public Regressor {
 public:
  explicit MovingLeastSquares(const RegressorState& state)
      : state_{state},
        cloud_{state.X},
        bandwidth_{state.hyper.at("bandwidth")},
        ridge_{state.hyper.at("ridge")} {}

  void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
               Eigen::Ref<Eigen::VectorXd> y) const noexcept override {
    const LocalPlane plane{cloud_.Z(), state_.Y, cloud_.scaled(x), bandwidth_,
                           [](Eigen::Index) { return true; }};
    y.setZero();
    plane.add_value(ridge_, cloud_.belief(plane.nearest()), y);
  }

  RegressorState state() const override { return state_; }

 private:
  RegressorState state_;
  PointCloud cloud_;
  double bandwidth_, ridge_;
};

}  // namespace

std::map<std::string, double> moving_least_squares_hyper(const RegressionData& data) {
  constexpr std::array kBandwidths{0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0};  // times sqrt(d / 6)
  constexpr std::array kRidges{1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0};
  const PointCloud cloud{data.X};
  const std::vector<int> groups = group_numbers(data.groups, data.X.rows());
  const double unit = std::sqrt(static_cast<double>(data.X.cols()) / 6);
  double smallest = std::numeric_limits<double>::infinity();
  std::map<std::string, double> best;
  for (const double bandwidth : kBandwidths) {
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(kRidges.size());
    for (Eigen::Index i = 0; i < data.X.rows(); ++i) {
      const auto elsewhere = [&](Eigen::Index j) {
        return groups[static_cast<std::size_t>(j)] != groups[static_cast<std::size_t>(i)];
      };
      const LocalPlane plane{cloud.Z(), data.Y, cloud.Z().row(i).transpose(), bandwidth * unit, elsewhere};
      for (std::size_t r = 0; r < kRidges.size(); ++r) {
        Eigen::VectorXd y = Eigen::VectorXd::Zero(data.Y.cols());
        plane.add_value(kRidges[r], 1, y);
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

RegressorPtr make_moving_least_squares(const RegressorState& state) {
  return std::make_shared<MovingLeastSquares>(state);
}

}  // namespace truepose
