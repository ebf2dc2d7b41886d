#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"
#include "core/calibration/measurement_noise.hpp"
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
  /// @param candidates  poses of the first reflector
  /// @param task        poses whose predictions matter
  /// @param noise       of a reading
  DesignProblem(const CalibratedCell& cell, std::span<const JointVector> candidates,
                std::span<const JointVector> task, const MeasurementNoise& noise,
                const DesignPrior& prior = {});

  std::size_t candidates() const { return candidates_; }
  Eigen::Index parameters() const { return task_rows_.cols(); }

  /// Rows of a candidate, 3 x parameters().
  Eigen::Matrix<double, 3, Eigen::Dynamic> rows(std::size_t candidate) const;
  /// Derivative of the task's positions (mm) to the scaled parameters, three rows a pose.
  const Eigen::MatrixXd& task_rows() const { return task_rows_; }
  /// Mean of what the task's poses ask of the parameters, mm^2: the mean squared error of their predictions
  /// (mm^2, of the error's length) is the trace of its product with the covariance.
  const Eigen::MatrixXd& task() const { return task_; }

  /// All candidates' rows as the kernels take them: blocks of kMostLanes candidates, in each entry (r, c) of
  /// the rows at (r * parameters() + c), one candidate a lane. The last block is filled up with zeros.
  const std::vector<kernels::Line>& blocks() const { return blocks_; }

 private:
  std::size_t candidates_;
  std::vector<kernels::Line> blocks_;
  Eigen::MatrixXd task_rows_;
  Eigen::MatrixXd task_;
};

}  // namespace truepose
