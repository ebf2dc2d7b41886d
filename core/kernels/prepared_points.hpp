#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/calibration/measurement.hpp"
#include "core/kernels/kernels.hpp"

namespace truepose {

/// Measured points in the layout of the kernels: by reflector, one array a coordinate, with the sines and
/// cosines of the joints, which an identification needs in every iteration and which never change.
///
/// Depends on the arm by the types and signs of its joints alone. Where an arm's joints deviate from what its
/// controller says, pass the points with the joints that it really took.
class PreparedPoints {
 public:
  /// @param reflectors  how many the points' `smr` may name
  /// @param weights     of each point (1 / sigma, relative); empty = all alike
  PreparedPoints(const RobotModel& robot, std::span<const Measurement> points, int reflectors,
                 const Eigen::VectorXd& weights = {}, const kernels::Kernels& code = kernels::best());

  /// Other weights for the same points, as a robust loss needs; empty = all alike. Does not allocate.
  void reweight(const Eigen::VectorXd& weights);

  int size() const { return static_cast<int>(place_.size()); }
  int joint_count() const { return joints_; }
  int reflectors() const { return static_cast<int>(begin_.size()) - 1; }
  const kernels::Kernels& code() const { return *code_; }

  /// The points of one reflector, padded with points of weight 0.
  kernels::PointBlock of_reflector(int reflector) const;

 private:
  enum Row { kX, kY, kZ, kWeight, kJoints };  ///< arrays; from kJoints on first and second of PointBlock

  double* row(int number) { return lines_[static_cast<std::size_t>(number * row_lines_)].value; }
  const double* row(int number) const { return lines_[static_cast<std::size_t>(number * row_lines_)].value; }

  const kernels::Kernels* code_;
  int joints_;
  int row_lines_ = 0;  ///< length of an array over all points
  std::vector<kernels::Line> lines_;
  std::vector<int> begin_;  ///< first place of each reflector's points, and the end of all
  std::vector<int> place_;  ///< of each point, in the caller's order
};

}  // namespace truepose
