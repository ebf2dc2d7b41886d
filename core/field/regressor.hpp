#pragma once

#include <Eigen/Core>
#include <expected>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose {

/// Bounds that let a prediction live on the stack.
inline constexpr int kMaxFeatures = 32;
inline constexpr int kMaxTargets = 12;

/// What is left of a measured error, and the features of the pose that shall explain it. Features may have
/// any unit: every method scales them to unit spread. Targets share a unit, and zero means that nothing is
/// left.
struct RegressionData {
  Eigen::MatrixXd X;        ///< N x d features
  Eigen::MatrixXd Y;        ///< N x m targets
  std::vector<int> groups;  ///< of each point: those of one group are left out together; empty = each its own
};

/// Nothing where the data can be fitted, else what is wrong with them, as a sentence: fewer than four points,
/// shapes that do not match, too many features or targets, numbers that are not finite.
std::optional<std::string> fault_of(const RegressionData& data);

/// Numbers of the groups of N points: 0 .. G - 1 in ascending order of the groups' own. Empty = each its own.
std::vector<int> group_numbers(const std::vector<int>& groups, Eigen::Index points);

/// Hyper-parameters by name, as the method that found them describes them.
using Hyper = std::map<std::string, double>;

/// What a fitted regressor is made of.
struct RegressorState {
  Eigen::MatrixXd X;  ///< N x d, of the fit
  Eigen::MatrixXd Y;  ///< N x m
  Hyper hyper;
};

/// A field fitted to data. It is zero far from the data, however it was fitted.
class Regressor {
 public:
  explicit Regressor(RegressorState state) : state_{std::move(state)} {}
  virtual ~Regressor() = default;
  Regressor(const Regressor&) = delete;
  Regressor& operator=(const Regressor&) = delete;

  /// The targets expected at features `x` (d) into `y` (m). Does not allocate.
  virtual void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
                       Eigen::Ref<Eigen::VectorXd> y) const noexcept = 0;

  /// Variance of that expectation, per target and without the noise of a measurement. A method that knows
  /// none of its own says what there is to expect: the mean square of the targets. May allocate.
  virtual Eigen::VectorXd variance(const Eigen::Ref<const Eigen::VectorXd>& x) const;

  /// Variance of a measured target about what is expected of it, per target: noise, and what changes too fast
  /// to be predicted. Zero where the method does not know.
  virtual Eigen::VectorXd noise() const;

  /// How many parameters of each target it is worth: the trace of the matrix that makes predictions at the
  /// poses of the fit of the targets there. Nothing where the method has none.
  virtual std::optional<double> freedom() const { return std::nullopt; }

  const RegressorState& state() const { return state_; }

 private:
  RegressorState state_;
};

using RegressorPtr = std::shared_ptr<const Regressor>;

/// A method of regression, for data without a fault. Always the same for the same data.
struct RegressionMethod {
  std::string_view name;
  /// Fits, hyper-parameters included, on so many threads; the result is the same with any number.
  RegressorPtr (*fit)(const RegressionData& data, int jobs);
  /// The same with hyper-parameters found before, on these or other data.
  RegressorPtr (*refit)(const Hyper& hyper, const RegressionData& data);
};

/// Errors: fault_of().
std::expected<RegressorPtr, std::string> fit_regressor(const RegressionMethod& method,
                                                       const RegressionData& data, int jobs = 1);

}  // namespace truepose
