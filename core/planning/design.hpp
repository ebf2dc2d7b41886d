#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/planning/design_problem.hpp"

namespace truepose {

enum class DesignCriterion {
  D,  ///< the smallest volume of the parameters' uncertainty
  A,  ///< the smallest mean variance of the parameters, in units of what is known of them before
  I,  ///< the smallest mean variance of the predicted positions of the task
};

/// A set of chosen candidates, and what each other one would add to it. Adding or removing a pose brings the
/// 3 x 3 matrices of all candidates up to date by products of 3 x n with n x 3, in place of a determinant or
/// an inverse each (n parameters).
///
/// With C the covariance of the chosen poses and A a candidate's rows, V = A C A' and W = A C T C A' are kept
/// of every candidate; T is the identity (A) or the task (I), and W is not needed for D. By the matrix
/// determinant lemma the candidate multiplies the determinant of the information by det(I + V), and by
/// Woodbury's identity it lowers trace(T C) by trace((I + V)^-1 W).
class Design {
 public:
  /// An empty one. `problem` outlives it.
  Design(const DesignProblem& problem, DesignCriterion criterion,
         const kernels::Kernels& kernels = kernels::best());

  void add(std::size_t candidate);
  void remove(std::size_t candidate);
  /// Reckons everything anew: after many changes rounding adds up.
  void refresh();

  /// What adding each candidate would bring (> 1 for D, > 0 for A and I; more is better).
  std::span<const double> gains();
  /// Less is better: the logarithm of the determinant of C for D, the trace of T C for A and I.
  double cost() const;

  const std::vector<std::size_t>& chosen() const { return chosen_; }
  bool has(std::size_t candidate) const { return is_chosen_[candidate]; }
  const Eigen::MatrixXd& covariance() const { return C_; }

 private:
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  void change(std::size_t candidate, double sign);
  void reckon_gains();
  void project(const Rows& Ut, std::vector<kernels::Line>& X) const;
  void add_products(const std::vector<kernels::Line>& X, const std::vector<kernels::Line>& Y, double factor,
                    std::vector<kernels::Line>& S) const;

  const DesignProblem& problem_;
  const kernels::Kernels& kernels_;
  int blocks_;
  std::vector<std::size_t> chosen_;
  std::vector<bool> is_chosen_;
  Eigen::MatrixXd T_;  // empty for D
  Eigen::MatrixXd C_;
  double best_gain_ = 0;  // when all was reckoned anew
  std::vector<kernels::Line> V_, W_, X_, Y_, gain_;
};

/// Standard deviations of the task's predicted positions (mm, of the error's length) that a design leads to.
struct PredictedError {
  double rms_mm = 0;  ///< over the task's poses
  double max_mm = 0;  ///< at the worst of them
};
PredictedError predicted_error(const DesignProblem& problem, const Eigen::MatrixXd& covariance);
/// @param chosen  candidates
PredictedError predicted_error(const DesignProblem& problem, std::span<const std::size_t> chosen);

}  // namespace truepose
