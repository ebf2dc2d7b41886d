#include "core/field/regressor.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/field/gaussian_process.hpp"
#include "core/field/inverse_distance.hpp"
#include "core/field/kriging.hpp"
#include "core/field/moving_least_squares.hpp"
#include "core/field/neural_network.hpp"
#include "core/field/point_cloud.hpp"

namespace truepose {
namespace {

constexpr Eigen::Index kFewestPoints = 4;

using Hyper = std::map<std::string, double>;

/// Nothing where the data can be fitted, else what is wrong with them.
std::optional<std::string> fault_of(const RegressionData& data) {
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

struct HyperRange {
  std::string name;
  double low, high;
};

std::vector<HyperRange> hyper_ranges(RegressorKind kind, Eigen::Index features) {
  constexpr double kHuge = std::numeric_limits<double>::max(), kTiny = std::numeric_limits<double>::min();
  switch (kind) {
    case RegressorKind::GaussianProcess: {
      std::vector<HyperRange> ranges{{"matern", 0, 1}, {"noise_ratio", 0, kHuge}};
      for (Eigen::Index k = 0; k < features; ++k)
        ranges.push_back({"length." + std::to_string(k), kTiny, kHuge});
      return ranges;
    }
    case RegressorKind::Kriging:
      return {{"model", 0, 2},
              {"nugget", 0, kHuge},
              {"sill", 0, kHuge},
              {"range", kTiny, kHuge},
              {"neighbours", 1, kMaxNeighbours}};
    case RegressorKind::InverseDistance:
      return {{"neighbours", 1, kMaxNeighbours}, {"power", 0, 16}};
    case RegressorKind::MovingLeastSquares:
      return {{"bandwidth", kTiny, kHuge}, {"ridge", kTiny, kHuge}};
    case RegressorKind::NeuralNetwork:
      return {{"hidden", 1, 64}, {"members", 1, 64}, {"decay", 0, kHuge}, {"noise", 0, kHuge}};
  }
  return {};
}

std::optional<std::string> fault_of(RegressorKind kind, const Hyper& hyper, Eigen::Index features) {
  for (const HyperRange& range : hyper_ranges(kind, features)) {
    const auto found = hyper.find(range.name);
    if (found == hyper.end())
      return "residual field " + std::string{name_of(kind)} + ": hyper-parameter " + range.name +
             " is missing";
    if (!(found->second >= range.low && found->second <= range.high))
      return "residual field " + std::string{name_of(kind)} + ": hyper-parameter " + range.name +
             " is out of its range";
  }
  return std::nullopt;
}

RegressorPtr make(const RegressorState& state) {
  switch (state.kind) {
    case RegressorKind::GaussianProcess:
      return make_gaussian_process(state);
    case RegressorKind::Kriging:
      return make_kriging(state);
    case RegressorKind::InverseDistance:
      return make_inverse_distance(state);
    case RegressorKind::MovingLeastSquares:
      return make_moving_least_squares(state);
    case RegressorKind::NeuralNetwork:
      return make_neural_network(state);
  }
  return nullptr;
}

RegressorState fit(RegressorKind kind, const RegressionData& data, int jobs) {
  switch (kind) {
    case RegressorKind::GaussianProcess:
      return {kind, data.X, data.Y, gaussian_process_hyper(data, jobs), {}};
    case RegressorKind::Kriging:
      return {kind, data.X, data.Y, kriging_hyper(data), {}};
    case RegressorKind::InverseDistance:
      return {kind, data.X, data.Y, inverse_distance_hyper(data), {}};
    case RegressorKind::MovingLeastSquares:
      return {kind, data.X, data.Y, moving_least_squares_hyper(data), {}};
    case RegressorKind::NeuralNetwork:
      return fit_neural_network(data);
  }
  return {};
}

}  // namespace

std::string_view name_of(RegressorKind kind) { return name_of(kRegressorNames, kind); }

std::optional<RegressorKind> regressor_kind(std::string_view name) {
  const auto found = std::ranges::find(kRegressorNames, name, &Named<RegressorKind>::name);
  if (found == kRegressorNames.end()) return std::nullopt;
  return found->value;
}

std::vector<std::string_view> residual_names() {
  std::vector<std::string_view> names{"none", "auto"};
  std::ranges::copy(names_of(kRegressorNames), std::back_inserter(names));
  return names;
}

std::optional<std::vector<RegressorKind>> residual_kinds(std::string_view name) {
  if (name == "none") return std::vector<RegressorKind>{};
  if (name == "auto") return std::vector{RegressorKind::GaussianProcess, RegressorKind::Kriging};
  const auto kind = regressor_kind(name);
  if (!kind) return std::nullopt;
  return std::vector{*kind};
}

Eigen::VectorXd Regressor::variance(const Eigen::Ref<const Eigen::VectorXd>&) const {
  return target_scale(state().Y).cwiseAbs2();
}

Eigen::VectorXd Regressor::noise() const { return Eigen::VectorXd::Zero(state().Y.cols()); }

std::expected<RegressorPtr, std::string> fit_regressor(RegressorKind kind, const RegressionData& data,
                                                       int jobs) {
  if (auto fault = fault_of(data)) return std::unexpected{*fault};
  return make(fit(kind, data, jobs));
}

std::expected<RegressorPtr, std::string> refit_regressor(const RegressorState& like,
                                                         const RegressionData& data) {
  if (auto fault = fault_of(data)) return std::unexpected{*fault};
  if (auto fault = fault_of(like.kind, like.hyper, data.X.cols())) return std::unexpected{*fault};
  if (like.kind == RegressorKind::NeuralNetwork) return make(refit_neural_network(like.hyper, data));
  return make({like.kind, data.X, data.Y, like.hyper, {}});
}

std::expected<RegressorPtr, std::string> restore_regressor(const RegressorState& state) {
  if (auto fault = fault_of(RegressionData{state.X, state.Y, {}})) return std::unexpected{*fault};
  if (auto fault = fault_of(state.kind, state.hyper, state.X.cols())) return std::unexpected{*fault};
  const std::size_t weights = state.kind == RegressorKind::NeuralNetwork ? neural_network_weights(state) : 0;
  if (state.weights.size() != weights)
    return std::unexpected{"residual field " + std::string{name_of(state.kind)} + ": expected " +
                           std::to_string(weights) + " weights, there are " +
                           std::to_string(state.weights.size())};
  return make(state);
}

}  // namespace truepose
