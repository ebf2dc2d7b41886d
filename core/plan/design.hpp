#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/choices.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/kernels/kernels.hpp"

namespace truepose {

/// How far a cell may be from what is known of it before it is measured: standard deviations. They hold the
/// information of a design finite where its poses do not tell a parameter.
struct DesignPrior {
  double base_mm = 50;
  double base_rad = 50e-3;
  double reflector_mm = 5;
  double length_mm = 1;     ///< a, d
  double angle_rad = 5e-3;  ///< alpha, theta, beta
};

/// What measuring each of many candidate poses would tell, and of which predictions it is wanted.
///
/// All in units of the prior's standard deviations, so that the information before any measurement is the
/// identity, and of the readings' standard deviations.
class DesignProblem {
 public:
  /// @param cell        roughly known, for its Jacobian alone
  /// @param candidates  poses to measure
  /// @param task        poses whose predictions matter, of the first reflector
  /// @param noise       of a reading
  /// @param seen        the reflector of the cell that is measured at each candidate; empty: the first
  DesignProblem(const CalibratedCell& cell, std::span<const JointVector> candidates,
                std::span<const JointVector> task, const MeasurementNoise& noise,
                const DesignPrior& prior = {}, std::span<const int> seen = {});

  std::size_t candidates() const { return candidates_; }
  Eigen::Index parameters() const { return task_rows_.cols(); }

  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  /// Rows of a candidate, 3 x parameters().
  Rows rows(std::size_t candidate) const;
  /// Derivative of the task's positions (mm) to the scaled parameters, three rows a pose.
  const Eigen::MatrixXd& task_rows() const { return task_rows_; }
  /// Mean of what the task's poses ask of the parameters, mm^2: the mean squared error of their predictions
  /// (mm^2, of the error's length) is the trace of its product with the covariance.
  const Eigen::MatrixXd& task() const { return task_; }

  /// All candidates' rows as the kernels take them: blocks of kMostLanes candidates, in each entry (r, c) of
  /// the rows at (r * parameters() + c), one candidate a lane. The last block is filled up with zeros.
  const std::vector<kernels::Line>& blocks() const { return blocks_; }

 private:
  void put_rows(std::size_t candidate, const Rows& rows);

  std::size_t candidates_;
  std::vector<kernels::Line> blocks_;
  Eigen::MatrixXd task_rows_;
  Eigen::MatrixXd task_;
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
  /// Puts back, as if it had never been missing, what the last change removed.
  void take_back(std::size_t removed);
  /// Recomputes everything, because rounding adds up over many changes.
  void refresh();

  /// What adding each candidate would bring (> 1 for D, > 0 for A and I; more is better).
  std::span<const double> gains();
  /// Less is better: the logarithm of the determinant of C for D, the trace of T C for A and I.
  double cost() const;

  const std::vector<std::size_t>& chosen() const { return chosen_; }
  bool has(std::size_t candidate) const { return is_chosen_[candidate]; }
  const Eigen::MatrixXd& covariance() const { return C_; }

 private:
  using Rows = DesignProblem::Rows;

  void change(std::size_t candidate, double sign);
  void reckon_gains();
  int columns() const { return static_cast<int>(problem_.parameters()); }
  /// S = A M A' of every candidate.
  void reckon_congruences(const Eigen::MatrixXd& M, std::vector<kernels::Line>& S) const;

  const DesignProblem& problem_;
  const kernels::Kernels& kernels_;
  int blocks_;
  std::vector<std::size_t> chosen_;
  std::vector<bool> is_chosen_;
  Eigen::MatrixXd T_;  // empty for D
  Eigen::MatrixXd C_;
  double best_gain_ = 0;  // at the last refresh()
  std::vector<kernels::Line> V_, W_, gain_;
  std::vector<kernels::Line> V_before_, W_before_;  // the last change, where that removed
  Eigen::MatrixXd C_before_;
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
