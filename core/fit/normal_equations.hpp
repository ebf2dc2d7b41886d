#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/least_squares_problem.hpp"
#include "core/fit/prepared_points.hpp"

namespace truepose {

/// J'J, J'f and f'f of what linearise() says of prepared points and a prior, without ever holding the
/// Jacobian. f: residuals (predicted minus measured, mm), whitened or weighed as the points were prepared.
class NormalEquations {
 public:
  /// More parameters of links and deviations than these can be free only in linearise().
  static constexpr int kMostLinkParameters = kernels::kMostLinkColumns;

  /// @param cell    of the structure (joints, deviations, reflectors, stations) that will be evaluated, and
  /// for whose arm the points were prepared; kept by reference like the prior
  /// @param free    indices of ParameterLayout, ascending
  NormalEquations(const CalibratedCell& cell, PreparedPoints& points, const std::vector<int>& free,
                  const Prior& prior);

  /// Evaluates all of them at `cell`, whose deviations become those of the points. Allocates for a prior
  /// alone.
  void evaluate(const CalibratedCell& cell);

  int size() const { return static_cast<int>(place_.size()); }
  double cost() const { return cost_; }                                    ///< f'f, mm^2
  double gradient(int i) const { return gradient_[place(i)]; }             ///< J'f
  double product(int i, int j) const { return all_(place(i), place(j)); }  ///< J'J, i <= j

  Eigen::VectorXd gradient() const;
  Eigen::MatrixXd matrix() const;

 private:
  int place(int i) const { return place_[static_cast<std::size_t>(i)]; }
  void add(const kernels::PointModel& model, int station, int reflector);
  int place_of_local(int column, int station, int reflector) const;
  void add_translations(const kernels::PointSums& sums, int station, int reflector);
  void turn_base_to_tracker(int station, const Eigen::Matrix3d& R_WB);
  void add_prior(const CalibratedCell& cell);
  int local_columns() const;

  PreparedPoints& points_;
  ParameterLayout layout_;
  const std::vector<int>& free_;
  const Prior& prior_;
  std::vector<kernels::LinkColumn> columns_;
  // Base (3 + 3) of each station, all reflectors, the free columns of links and deviations. A superset of
  // what is free: it costs little and leaves one layout.
  Eigen::MatrixXd all_;  ///< upper half
  Eigen::VectorXd gradient_;
  double cost_ = 0;
  std::vector<int> place_;  ///< of each free parameter in them

  std::vector<kernels::Line> chunk_, gram_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> sums_;
};

}  // namespace truepose
