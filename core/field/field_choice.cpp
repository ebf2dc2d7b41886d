#include "core/field/field_choice.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/field/gaussian_process.hpp"
#include "core/math/parallel.hpp"
#include "core/math/random.hpp"
#include "core/math/statistics.hpp"
#include "core/step_count.hpp"

namespace truepose {
namespace {

constexpr Eigen::Index kFewPoints = 150;

/// The fold of each group: groups shuffled by the seed, then dealt one by one.
std::vector<int> deal_folds(int groups, const CrossValidationOptions& options) {
  std::vector<std::size_t> order(static_cast<std::size_t>(groups));
  std::iota(order.begin(), order.end(), 0);
  Random random{options.seed};
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random.next() % (i + 1)]);
  std::vector<int> folds(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) folds[order[i]] = static_cast<int>(i) % options.folds;
  return folds;
}

std::size_t group_of(const std::vector<int>& groups, Eigen::Index point) {
  return static_cast<std::size_t>(groups[static_cast<std::size_t>(point)]);
}

RegressionData take(const RegressionData& data, const std::vector<Eigen::Index>& points,
                    const std::vector<int>& groups) {
  RegressionData some{data.X(points, Eigen::all), data.Y(points, Eigen::all), {}};
  for (const Eigen::Index i : points) some.groups.push_back(static_cast<int>(group_of(groups, i)));
  return some;
}

/// rms and its standard error from the squared errors of groups.
/// @param expected_squares  of the folds
void summarise(CrossValidation& result, std::span<const double> expected_squares, Eigen::Index points) {
  const auto& errors = result.squared_errors;
  const double groups = static_cast<double>(errors.size()), N = static_cast<double>(points);
  const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
  double spread = 0;
  for (const double e : errors) spread += (e - sum / groups) * (e - sum / groups);
  result.rms = std::sqrt(sum / N);
  // Of the mean square first: sqrt(groups * variance between them) / N; then through the root.
  const double of_mean_square = std::sqrt(groups * spread / (groups - 1)) / N;
  result.standard_error = result.rms > 0 ? of_mean_square / (2 * result.rms) : 0;
  result.expected_rms = std::sqrt(std::accumulate(expected_squares.begin(), expected_squares.end(), 0.0) / N);
}

/// Predicts the points of one fold from the others.
/// @param expected_square  the sum of the squared errors as the fit expects it
/// @return why not, or nothing
std::optional<std::string> predict_fold(const RegressionData& data, const std::vector<int>& groups,
                                        const std::vector<int>& folds, int fold,
                                        const RegressionMethod& method, CrossValidation& result,
                                        double& expected_square) {
  count_step();
  std::vector<Eigen::Index> inside, outside;
  for (Eigen::Index i = 0; i < data.X.rows(); ++i)
    (folds[group_of(groups, i)] == fold ? outside : inside).push_back(i);
  if (outside.empty()) return std::nullopt;
  const RegressionData rest = take(data, inside, groups);
  if (auto fault = fault_of(rest)) return fault;
  const RegressorPtr fitted =
      result.on_all ? method.refit(result.on_all->state().hyper, rest) : method.fit(rest, 1);
  for (const Eigen::Index i : outside) {
    Eigen::VectorXd y(data.Y.cols());
    fitted->predict(data.X.row(i).transpose(), y);
    result.predicted.row(i) = y.transpose();
    result.squared_errors[group_of(groups, i)] += (data.Y.row(i).transpose() - y).squaredNorm();
    expected_square += fitted->variance(data.X.row(i).transpose()).sum() + fitted->noise().sum();
  }
  return std::nullopt;
}

constexpr double kLeastGain = 0.02;
/// Standard errors that a gain must exceed, where groups are many. Of few groups the standard error itself is
/// uncertain: 3 for 20 groups.
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
bool is_significant(const std::vector<double>& without, const std::vector<double>& with) {
  const auto groups = static_cast<double>(without.size());
  return standard_errors_gained(without, with) > kStandardErrors * (1 + kFewGroups / groups);
}

bool helps(const FieldChoice& choice, const RegressionData& data) {
  return choice.tried.rms < (1 - kLeastGain) * choice.rms_zero &&
         is_significant(squared_targets(data), choice.tried.squared_errors);
}

}  // namespace

std::expected<CrossValidation, std::string> cross_validate(const RegressionMethod& method,
                                                           const RegressionData& data,
                                                           const CrossValidationOptions& options) {
  const std::vector<int> groups = group_numbers(data.groups, data.X.rows());
  const int count = groups.empty() ? 0 : *std::ranges::max_element(groups) + 1;
  if (count < 2 || options.folds < 2)
    return std::unexpected{"cross-validation needs two groups and two folds"};
  CrossValidation result{.squared_errors = std::vector<double>(static_cast<std::size_t>(count)),
                         .predicted = Eigen::MatrixXd::Zero(data.Y.rows(), data.Y.cols()),
                         .on_all = nullptr};
  if (data.X.rows() > kFewPoints) {
    auto on_all = fit_regressor(method, data, options.jobs);
    if (!on_all) return std::unexpected{on_all.error()};
    result.on_all = *std::move(on_all);
  }
  const std::vector<int> folds = deal_folds(count, options);
  std::vector<std::optional<std::string>> faults(static_cast<std::size_t>(options.folds));
  std::vector<double> expected_squares(faults.size());
  parallel_for(options.folds, options.jobs, [&](int fold) {
    const auto k = static_cast<std::size_t>(fold);
    faults[k] = predict_fold(data, groups, folds, fold, method, result, expected_squares[k]);
  });
  for (const auto& fault : faults)
    if (fault) return std::unexpected{*fault};
  summarise(result, expected_squares, data.X.rows());
  return result;
}

std::expected<FieldChoice, std::string> choose_field(const RegressionData& data, FieldUse use,
                                                     const CrossValidationOptions& options) {
  auto tried = cross_validate(kGaussianProcess, data, options);
  if (!tried) return std::unexpected{tried.error()};
  FieldChoice choice{.rms_zero = std::sqrt(data.Y.squaredNorm() / static_cast<double>(data.Y.rows())),
                     .tried = *std::move(tried),
                     .regressor = nullptr};
  choice.chosen = use == FieldUse::Always || helps(choice, data);
  if (!choice.chosen) return choice;
  auto fitted = choice.tried.on_all ? choice.tried.on_all : fit_regressor(kGaussianProcess, data);
  if (!fitted) return std::unexpected{fitted.error()};
  choice.regressor = *std::move(fitted);
  return choice;
}

}  // namespace truepose
