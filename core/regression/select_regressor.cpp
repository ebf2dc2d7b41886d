#include "core/regression/select_regressor.hpp"

#include <algorithm>
#include <cmath>

#include "core/regression/point_cloud.hpp"

namespace truepose {
namespace {

constexpr double kLeastRegressorGain = 0.02;
/// Standard errors that a gain must exceed, where groups are many. Of few groups the standard error itself is
/// uncertain, and the best of several kinds is compared: 3 for 20 groups.
constexpr double kStandardErrors = 2;
constexpr double kFewGroups = 10;

/// Squared length of the targets of each group: the errors of predicting zero.
std::vector<double> squared_targets(const RegressionData& data) {
  const std::vector<int> groups = group_numbers(data.groups, data.X.rows());
  std::vector<double> sums(static_cast<std::size_t>(*std::ranges::max_element(groups)) + 1);
  for (Eigen::Index i = 0; i < data.Y.rows(); ++i)
    sums[static_cast<std::size_t>(groups[static_cast<std::size_t>(i)])] += data.Y.row(i).squaredNorm();
  return sums;
}

/// Whether the errors are smaller than those without by more than chance.
bool beyond_chance(const std::vector<double>& without, const std::vector<double>& with) {
  const double groups = static_cast<double>(without.size());
  double sum = 0, squares = 0;
  for (std::size_t g = 0; g < without.size(); ++g) {
    const double gain = without[g] - with[g];
    sum += gain;
    squares += gain * gain;
  }
  const double variance = (squares - sum * sum / groups) / (groups - 1);
  return sum > kStandardErrors * (1 + kFewGroups / groups) * std::sqrt(groups * variance);
}

}  // namespace

std::expected<RegressorSelection, std::string> select_regressor(const RegressionData& data,
                                                                std::span<const RegressorKind> kinds,
                                                                const CrossValidationOptions& options) {
  RegressorSelection selection;
  for (const RegressorKind kind : kinds) {
    auto tried = cross_validate(kind, data, options);
    if (!tried) return std::unexpected{tried.error()};
    selection.tried.push_back(std::move(*tried));
  }
  selection.rms_zero = std::sqrt(data.Y.squaredNorm() / static_cast<double>(data.Y.rows()));
  const auto best = std::ranges::min_element(selection.tried, {}, &CrossValidation::rms);
  if (best == selection.tried.end() || best->rms >= (1 - kLeastRegressorGain) * selection.rms_zero ||
      !beyond_chance(squared_targets(data), best->squared_errors))
    return selection;
  auto fitted = fit_regressor(best->kind, data);
  if (!fitted) return std::unexpected{fitted.error()};
  selection.kind = best->kind;
  selection.regressor = std::move(*fitted);
  return selection;
}

}  // namespace truepose
