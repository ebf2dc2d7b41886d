#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tools/experiment/point_cloud.hpp"
#include "tools/experiment/regression_methods.hpp"

namespace truepose {
namespace {

/// Adds the weighted mean of the neighbours' targets to `y`, times `belief`. Within a thousandth of the
/// spacing all weigh alike, so that repeated poses are averaged.
void add_mean(std::span<const Neighbour> neighbours, double power, double spacing, double belief,
              const Eigen::MatrixXd& Y, Eigen::Ref<Eigen::VectorXd> y) {
  std::array<double, kMaxNeighbours> weights;
  double sum = 0;
  for (std::size_t i = 0; i < neighbours.size(); ++i)
    sum += weights[i] = std::pow(std::hypot(neighbours[i].distance / spacing, 1e-3), -power);
  for (std::size_t i = 0; i < neighbours.size(); ++i)
    y += belief * weights[i] / sum * Y.row(neighbours[i].point).transpose();
}

class InverseDistance final : public Regressor {
 public:
  explicit InverseDistance(RegressorState of)
      : Regressor{std::move(of)},
        cloud_{state().X},
        neighbours_{static_cast<int>(state().hyper.at("neighbours"))},
        power_{state().hyper.at("power")} {}

  void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
               Eigen::Ref<Eigen::VectorXd> y) const noexcept override {
    const Neighbours near = cloud_.nearest(cloud_.scaled(x), neighbours_);
    y.setZero();
    add_mean(near.span(), power_, cloud_.spacing(), cloud_.belief(near.span().front().distance), state().Y,
             y);
  }

 private:
  PointCloud cloud_;
  int neighbours_;
  double power_;
};

Hyper inverse_distance_hyper(const RegressionData& data) {
  constexpr std::array<std::size_t, 4> kNeighbours{4, 8, 16, 32};
  constexpr std::array kPowers{1.0, 2.0, 3.0, 4.0, 6.0};
  const PointCloud cloud{data.X};
  const std::vector<int> groups = group_numbers(data.groups, data.X.rows());
  Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(kNeighbours.size(), kPowers.size());
  for (int i = 0; i < cloud.size(); ++i) {
    const auto elsewhere = [&](int j) {
      return groups[static_cast<std::size_t>(j)] != groups[static_cast<std::size_t>(i)];
    };
    const Neighbours near = cloud.nearest(cloud.Z().row(i).transpose(), kMaxNeighbours, elsewhere);
    for (std::size_t n = 0; n < kNeighbours.size(); ++n) {
      const auto some = near.span().first(std::min(near.span().size(), kNeighbours[n]));
      for (std::size_t p = 0; p < kPowers.size(); ++p) {
        Eigen::VectorXd y = Eigen::VectorXd::Zero(data.Y.cols());
        add_mean(some, kPowers[p], cloud.spacing(), 1, data.Y, y);
        errors(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(p)) +=
            (data.Y.row(i).transpose() - y).squaredNorm();
      }
    }
  }
  Eigen::Index n = 0, p = 0;
  errors.minCoeff(&n, &p);
  return {{"neighbours", static_cast<double>(kNeighbours[static_cast<std::size_t>(n)])},
          {"power", kPowers[static_cast<std::size_t>(p)]}};
}

}  // namespace

const RegressionMethod kInverseDistance{
    .name = "idw",
    .fit = [](const RegressionData& data, int /*jobs*/) -> RegressorPtr {
      return std::make_shared<InverseDistance>(RegressorState{data.X, data.Y, inverse_distance_hyper(data)});
    },
    .refit = [](const Hyper& hyper, const RegressionData& data) -> RegressorPtr {
      return std::make_shared<InverseDistance>(RegressorState{data.X, data.Y, hyper});
    }};

}  // namespace truepose
