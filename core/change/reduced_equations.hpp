#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "core/change/change_evidence.hpp"
#include "core/change/time_evidence.hpp"

namespace truepose {

/// Normal equations of columns in addition to the identified parameters, which are left free: reduced by what
/// those explain. Sums over points, so that those of a stretch are the difference of two.
class ReducedEquations {
 public:
  ReducedEquations(const TimeEvidence& evidence, Eigen::Index columns);

  /// @param A  the columns at the point, whitened
  void add(const TimeEvidence& evidence, std::size_t point, const Eigen::MatrixXd& A);
  /// The columns of the one, then those of the other, for points that are not the same.
  ReducedEquations joined_with(const ReducedEquations& other) const;
  ReducedEquations less(const ReducedEquations& other) const;

  /// Of a change that moves the points by these columns.
  ChangeEvidence evidence(const TimeEvidence& evidence) const;

 private:
  Eigen::MatrixXd gram_;   // of the columns
  Eigen::MatrixXd along_;  // U' times them
  Eigen::VectorXd b_;      // their product with the residuals
};

}  // namespace truepose
