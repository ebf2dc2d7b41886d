#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/fit/least_squares_problem.hpp"

namespace truepose {

/// K-fold cross-validation of a linear problem over subsets of its last columns: all points of a pose are
/// left out together, the first columns are always fitted.
class LeftOutPoses {
 public:
  /// @param fitted  how many of `problem.free` are always fitted
  LeftOutPoses(const CalibratedCell& cell, const LeastSquaresProblem& problem, Eigen::Index fitted);

  /// Squared error (mm^2) of each fold as the others predict it.
  ///
  /// @param active  columns that are fitted too, counted from the first that is not always
  /// @param ridge   of each of them: added to its square sum
  std::vector<double> squared_errors(const std::vector<int>& active, const Eigen::VectorXd& ridge) const;

 private:
  struct Fold {
    Eigen::MatrixXd normal;  // of the other columns, from the other folds
    Eigen::VectorXd right;
    Eigen::MatrixXd here_normal;  // of the points left out
    Eigen::VectorXd here_right;
    double here_square = 0;  // squared error left out, without these columns
  };
  struct Normal {
    Eigen::MatrixXd JtJ;
    Eigen::VectorXd Jtf;
    double ff = 0;
  };
  static Normal normal_of(const Eigen::MatrixXd& J, const Eigen::VectorXd& f);
  static Fold eliminated(const Normal& all, const Normal& here, Eigen::Index geometry);

  std::vector<Fold> folds_;
};

}  // namespace truepose
