#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <vector>

#include "core/change/cell_change.hpp"
#include "core/change/movement.hpp"
#include "core/change/reduced_equations.hpp"
#include "core/change/time_evidence.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// When one thing may have moved, as the points that show it tell: of all moments the best. Points have the
/// numbers that the evidence has.
class MovementSearch {
 public:
  /// @param evidence  of the points; kept by reference
  /// @param change    of the cell
  /// @param points    in the order in which they were measured
  /// @param pose      pose_numbers() of them
  /// @param others    so many other things are as likely to have moved
  MovementSearch(const TimeEvidence& evidence, const CalibratedCell& cell, const PossibleChange& change,
                 std::span<const Measurement> points, std::span<const int> pose, double others);

  /// Whether enough poses show it.
  bool has_moments() const { return !moments_.empty(); }

  /// One step: any point may have been the first after it.
  Movement best_step() const;
  /// What changed before the first point, as what the model leaves out does.
  Movement always() const;
  /// Evenly, from the first point to the last.
  Movement trend() const;
  /// Two steps, as of a tracker that was bumped and set back.
  Movement best_two_steps() const;

 private:
  /// How much of a movement each point has made: a column for each movement, one after the other.
  using Shares = Eigen::MatrixXd;
  struct Trial;
  struct TwoMoments {
    std::size_t first = 0, again = 0;
    double gain = 0;
  };

  auto columns_at(const Eigen::MatrixXd& J, std::size_t k) const {
    return J.middleRows<3>(row_of(points_[k]));
  }
  Shares steps_at(std::initializer_list<std::size_t> moments) const;
  TwoMoments best_moments() const;
  ReducedEquations between_and_after(std::size_t first, std::size_t again) const;
  Eigen::VectorXd left_by(const Shares& shares, const Eigen::VectorXd& step) const;
  double moved_mm(const Shares& shares, const Eigen::VectorXd& step) const;
  Movement fitted(Movement movement, const Trial& trial) const;

  const TimeEvidence& evidence_;
  Change what_;
  Eigen::MatrixXd J_, moves_;  // its columns
  Eigen::Index columns_;
  std::vector<std::size_t> points_;   // that show it
  std::vector<std::size_t> moments_;  // of a step: places among these
  double others_;
  std::vector<ReducedEquations> from_;  // of all points from each place on, and from the end on
};

}  // namespace truepose
