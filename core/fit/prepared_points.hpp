#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/kernels/kernels.hpp"

namespace truepose {

/// Measured points in the layout of the kernels: by station and reflector, one array a coordinate, with the
/// sines and cosines of the joints, which an identification needs in every iteration and which change with
/// the deviations alone.
///
/// Depends on the arm by the types, signs and couplings of its joints, and by the bases of its deviations.
/// The motions of its guides are links of their own, see link_of_motion().
class PreparedPoints {
 public:
  /// @param reflectors  how many the points' `smr` may name
  /// @param W           multiplies the residual of each point (tracker frame); empty = all alike
  PreparedPoints(const RobotModel& robot, std::span<const Measurement> points, int reflectors,
                 std::span<const Eigen::Matrix3d> W = {}, const kernels::Kernels& code = kernels::best());

  /// Other weights for the same points, as a robust loss needs; empty = all alike.
  void reweight(std::span<const Eigen::Matrix3d> W);
  /// Puts the joints where `robot`, with other coefficients of the same deviations, has them. Does not
  /// allocate.
  void deviate(const RobotModel& robot);

  int size() const { return static_cast<int>(place_.size()); }
  int link_count() const { return static_cast<int>(links_.size()); }
  int stations() const { return static_cast<int>(begin_.size() - 1) / reflectors_; }
  int reflectors() const { return reflectors_; }
  const kernels::Kernels& code() const { return *code_; }

  /// Of each point, in the caller's order: its number within the arrays.
  const std::vector<int>& places() const { return place_; }
  /// Whether some points are whitened and not merely weighed.
  bool whitened() const { return whitened_; }
  int first_of(int station, int reflector) const { return begin_[group(station, reflector)]; }
  int end() const { return begin_.back(); }  ///< of the arrays
  /// The points of one reflector from one station, padded with points of weight 0.
  kernels::PointBlock of(int station, int reflector) const;

 private:
  /// Arrays over all points, of so many numbers each; links, readings and bases one for each of theirs.
  enum Row { kX, kY, kZ, kWeight, kWhitening, kLinks = kWhitening + 6 };

  std::size_t group(int station, int reflector) const {
    return static_cast<std::size_t>(station * reflectors_ + reflector);
  }
  double* row(int number) { return lines_[static_cast<std::size_t>(number * row_lines_)].value; }
  const double* row(int number) const { return lines_[static_cast<std::size_t>(number * row_lines_)].value; }
  int first_row(int link) const { return kLinks + link; }
  int second_row(int link) const { return kLinks + link_count() + link; }
  int reading_row(int link) const { return kLinks + 2 * link_count() + link; }
  int basis_row(int term) const { return kLinks + 3 * link_count() + term; }
  void place_bases(const RobotModel& robot, std::span<const Measurement> points);

  const kernels::Kernels* code_;
  int reflectors_;
  std::vector<JointType> links_;
  int row_lines_ = 0;  ///< length of an array over all points
  std::vector<kernels::Line> lines_;
  std::vector<int> begin_;            ///< first place of each group's points, and the end of all
  std::vector<int> place_;            ///< of each point, in the caller's order
  std::vector<double> coefficients_;  ///< of the deviations, as the joints stand
  bool placed_ = false;
  bool whitened_ = false;
};

/// The kernels' column of a parameter of a link or of a deviation. The column of a deviation is the zero of
/// its joint, or of a guide's motion (where it moves along: the length), times the basis.
kernels::LinkColumn link_column(const RobotModel& robot, const ParameterLayout& layout, int parameter);

/// The arm and columns of a cell in the kernels' form; the station and the reflector are set for each.
struct PreparedModel {
  kernels::Arm arm;
  kernels::PointModel model;

  PreparedModel(const CalibratedCell& cell, const std::vector<kernels::LinkColumn>& columns);
  PreparedModel(const PreparedModel&) = delete;
  const kernels::PointModel& of(const Eigen::Isometry3d& X_WB, const Reflector& reflector);
};

}  // namespace truepose
