#include "core/field/regressor.hpp"

#include <algorithm>
#include <numeric>

#include "core/field/scaled_points.hpp"

namespace truepose {

std::optional<std::string> fault_of(const RegressionData& data) {
  constexpr Eigen::Index kFewestPoints = 4;
  const Eigen::Index N = data.X.rows();
  if (N < kFewestPoints)
    return "a residual field needs " + std::to_string(kFewestPoints) + " points, there are " +
           std::to_string(N);
  if (data.Y.rows() != N || (!data.groups.empty() && data.groups.size() != static_cast<std::size_t>(N)))
    return "features, targets and groups of a residual field must be as many";
  if (data.X.cols() < 1 || data.X.cols() > kMaxFeatures || data.Y.cols() < 1 || data.Y.cols() > kMaxTargets)
    return "a residual field takes 1 to " + std::to_string(kMaxFeatures) + " features and 1 to " +
           std::to_string(kMaxTargets) + " targets";
  if (!data.X.allFinite() || !data.Y.allFinite()) return "a residual field needs finite numbers";
  return std::nullopt;
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

Eigen::VectorXd Regressor::variance(const Eigen::Ref<const Eigen::VectorXd>&) const {
  return target_scale(state_.Y).cwiseAbs2();
}

Eigen::VectorXd Regressor::noise() const { return Eigen::VectorXd::Zero(state_.Y.cols()); }

std::expected<RegressorPtr, std::string> fit_regressor(const RegressionMethod& method,
                                                       const RegressionData& data, int jobs) {
  if (auto fault = fault_of(data)) return std::unexpected{*fault};
  return method.fit(data, jobs);
}

}  // namespace truepose
