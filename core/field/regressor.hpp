#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <expected>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/named.hpp"

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

enum class RegressorKind { GaussianProcess, Kriging, InverseDistance, MovingLeastSquares, NeuralNetwork };

inline constexpr std::array kAllRegressors{RegressorKind::GaussianProcess, RegressorKind::Kriging,
                                           RegressorKind::InverseDistance, RegressorKind::MovingLeastSquares,
                                           RegressorKind::NeuralNetwork};

inline constexpr std::array kRegressorNames{
    Named{"gp", RegressorKind::GaussianProcess}, Named{"kriging", RegressorKind::Kriging},
    Named{"idw", RegressorKind::InverseDistance}, Named{"mls", RegressorKind::MovingLeastSquares},
    Named{"nn", RegressorKind::NeuralNetwork}};

std::string_view name_of(RegressorKind kind);
std::optional<RegressorKind> regressor_kind(std::string_view name);

/// What a choice of residual fields is called: "none", "auto" (cross-validation chooses among those that know
/// how well they predict) or one kind.
std::vector<std::string_view> residual_names();
/// The kinds that such a name stands for. Nothing for any other name.
std::optional<std::vector<RegressorKind>> residual_kinds(std::string_view name);

/// All that a fitted regressor is, as plain numbers: written to a file and restored, it predicts the same to
/// the last bit.
struct RegressorState {
  RegressorKind kind = RegressorKind::GaussianProcess;
  Eigen::MatrixXd X;                    ///< N x d, of the fit
  Eigen::MatrixXd Y;                    ///< N x m
  std::map<std::string, double> hyper;  ///< by name, all of them needed
  std::vector<double> weights;          ///< of the neural network; empty for the others
};

/// A field fitted to data. It is zero far from the data, however it was fitted.
class Regressor {
 public:
  virtual ~Regressor() = default;

  /// The targets expected at features `x` (d) into `y` (m). Does not allocate.
  virtual void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
                       Eigen::Ref<Eigen::VectorXd> y) const noexcept = 0;

  /// Variance of that expectation, per target and without the noise of a measurement. A method that knows
  /// none of its own says what there is to expect: the mean square of the targets. May allocate.
  virtual Eigen::VectorXd variance(const Eigen::Ref<const Eigen::VectorXd>& x) const;

  /// Variance of a measured target about what is expected of it, per target: noise, and what changes too fast
  /// to be predicted. Zero where the method tells none.
  virtual Eigen::VectorXd noise() const;

  /// How many parameters of each target it is worth: the trace of the matrix that makes predictions at the
  /// poses of the fit of the targets there. Nothing where the method has none.
  virtual std::optional<double> freedom() const { return std::nullopt; }

  virtual RegressorState state() const = 0;

 protected:
  Regressor() = default;
  Regressor(const Regressor&) = default;
  Regressor& operator=(const Regressor&) = default;
};

using RegressorPtr = std::shared_ptr<const Regressor>;

/// Fits a regressor, its hyper-parameters included, always the same for the same data.
///
/// @param jobs  threads; the result is the same with any number
/// Errors, as a sentence: fewer than four points, shapes that do not match, too many features or targets,
/// numbers that are not finite.
std::expected<RegressorPtr, std::string> fit_regressor(RegressorKind kind, const RegressionData& data,
                                                       int jobs = 1);

/// The same with hyper-parameters found before, on these or other data.
std::expected<RegressorPtr, std::string> refit_regressor(const RegressorState& like,
                                                         const RegressionData& data);

/// The regressor that a state was taken from. Errors: as fit_regressor(); a hyper-parameter missing or out of
/// its range, which the sentence names.
std::expected<RegressorPtr, std::string> restore_regressor(const RegressorState& state);

}  // namespace truepose
