#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/calibration/measurement.hpp"
#include "core/kernels/kernels.hpp"

namespace truepose {

/// Measured points in the order and layout of the kernels: by reflector, one array a coordinate, with the
/// sines and cosines of the joints, which an identification needs in every iteration and which never change.
///
/// Depends on the arm by the types and signs of its joints alone. Where an arm's joints deviate from what its
/// controller says, pass the points with the joints that it really took.
class PreparedPoints {
 public:
  /// @param weights  of each point (1 / sigma, relative); empty = all alike
  PreparedPoints(const RobotModel& robot, std::span<const Measurement> points, int reflectors,
                 const Eigen::VectorXd& weights, const kernels::Kernels& code = kernels::best());

  /// Other weights for the same points, as a robust loss needs. Does not allocate.
  void reweight(const Eigen::VectorXd& weights);

  int size() const { return static_cast<int>(place_.size()); }
  int joint_count() const { return joints_; }
  int reflectors() const { return static_cast<int>(begin_.size()) - 1; }
  const kernels::Kernels& code() const { return *code_; }

  /// The points of one reflector; empty where it has none.
  kernels::PointBlock of_reflector(int reflector) const;

 private:
  /// One line of the widest vectors, so that the arrays start where vectors may be loaded whole.
  struct alignas(64) Line {
    double value[kernels::kMostLanes];
  };
  double* row(int number) { return lines_[static_cast<std::size_t>(number * stride_lines_)].value; }

  const kernels::Kernels* code_;
  int joints_ = 0;
  int stride_lines_ = 0;     ///< lines of one array over all points
  std::vector<Line> lines_;  ///< x, y, z (mm), weight, then two arrays a joint
  std::vector<int> begin_;   ///< first place of each reflector's points, and the end
  std::vector<int> place_;   ///< of each point, in the caller's order
};

}  // namespace truepose
