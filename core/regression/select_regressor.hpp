#pragma once

#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/regression/cross_validation.hpp"

namespace truepose {

struct RegressorSelection {
  std::optional<RegressorKind> kind;   ///< nothing: no residual field predicts better than zero
  RegressorPtr regressor;              ///< fitted to all data; null with no kind
  double rms_zero = 0;                 ///< of predicting zero: the error without a residual field
  std::vector<CrossValidation> tried;  ///< of each kind asked for, in that order
};

/// Chooses the kind with the smallest cross-validation error, and none unless that improves on predicting
/// zero beyond chance: by more than 2 % of the rms and more than 2 standard errors (3 for 20 groups) of the
/// paired differences between groups.
/// Errors: those of cross_validate().
std::expected<RegressorSelection, std::string> select_regressor(
    const RegressionData& data, std::span<const RegressorKind> kinds = kAllRegressors,
    const CrossValidationOptions& options = {});

}  // namespace truepose
