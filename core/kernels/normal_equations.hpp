#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"
#include "core/calibration/parameters.hpp"
#include "core/kernels/prepared_points.hpp"

namespace truepose {

/// J'WJ, J'Wf and f'Wf of the residuals f (predicted minus measured, mm) over prepared points, for some of a
/// cell's parameters: what linearise() says, without ever holding the Jacobian. W = diag(weight^2).
class NormalEquations {
 public:
  /// @param cell    of the structure (joints, reflectors) that will be evaluated; the points were prepared
  /// for its arm
  /// @param free    indices of ParameterLayout, ascending
  NormalEquations(const CalibratedCell& cell, const PreparedPoints& points, const std::vector<int>& free);

  /// Evaluates all of them at `cell`. Does not allocate.
  void evaluate(const CalibratedCell& cell);

  int size() const { return static_cast<int>(place_.size()); }
  double cost() const { return cost_; }                                    ///< f'Wf, mm^2
  double gradient(int i) const { return gradient_[place(i)]; }             ///< J'Wf
  double product(int i, int j) const { return all_(place(i), place(j)); }  ///< J'WJ, i <= j

  Eigen::VectorXd gradient() const;
  Eigen::MatrixXd matrix() const;

 private:
  int place(int i) const { return place_[static_cast<std::size_t>(i)]; }
  void add(const kernels::PointModel& model, int reflector);
  void turn_base_to_tracker(const Eigen::Matrix3d& R_WB);

  const PreparedPoints& points_;
  ParameterLayout layout_;
  std::vector<kernels::LinkColumn> columns_;
  // Base (3 + 3), all reflectors, the links' free columns. A superset of what is free: it costs little and
  // leaves one layout.
  Eigen::MatrixXd all_;  ///< upper half
  Eigen::VectorXd gradient_;
  double cost_ = 0;
  std::vector<int> place_;  ///< of each free parameter in them

  std::vector<kernels::Line> chunk_, gram_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> sums_;
};

}  // namespace truepose
