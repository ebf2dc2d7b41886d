#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <vector>

#include "core/choices.hpp"
#include "core/field/regressor.hpp"

namespace truepose {

struct CrossValidationOptions {
  int folds = 8;  ///< at most as many as there are groups
  std::uint64_t seed = 0;
  int jobs = 1;  ///< threads; the result is the same with any number
};

/// How a method predicts points that it has not seen. The error of a point is the length of its error vector.
struct CrossValidation {
  double rms = 0;
  double standard_error = 0;           ///< of the rms, from the spread between groups
  std::vector<double> squared_errors;  ///< of each group, summed over its points; groups in ascending order
  Eigen::MatrixXd predicted;           ///< N x m: of each point by a fit that did not see its group
  double expected_rms = 0;             ///< what the fits that predicted them expected the rms to be
  RegressorPtr on_all;                 ///< fitted to all data where the folds share its hyper-parameters
};

/// Leaves out one fold after the other and predicts it from the rest; points of one group share a fold.
/// Hyper-parameters are found again for every fold where the points are few enough for them to learn
/// something from those left out (up to 150), else once on all. Errors: those of fit_regressor(), for the
/// points that remain where a fold is left out; fewer than two groups or folds.
std::expected<CrossValidation, std::string> cross_validate(const RegressionMethod& method,
                                                           const RegressionData& data,
                                                           const CrossValidationOptions& options = {});

struct FieldChoice {
  bool chosen = false;
  double rms_zero = 0;  ///< of predicting zero: the error without a residual field
  CrossValidation tried;
  RegressorPtr regressor;  ///< fitted to all data; null where not chosen
};

/// Chooses the Gaussian process under FieldUse::Always, and under Auto where it improves on predicting zero
/// beyond chance: by more than 2 % of the rms and more than 2 standard errors (3 for 20 groups) of the paired
/// differences between groups. Errors: those of cross_validate().
std::expected<FieldChoice, std::string> choose_field(const RegressionData& data, FieldUse use,
                                                     const CrossValidationOptions& options = {});

}  // namespace truepose
