#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/measurement.hpp"

namespace truepose {

/// What may have changed since the calibration.
enum class DriftCauseKind {
  Base,       ///< the tracker or the base moved: 6 unknowns
  Reflector,  ///< moved on the flange: 3
  JointZero,  ///< the encoder of a joint reads another angle: 1
  Reading,    ///< one point is wrong, its 3 coordinates tell nothing
  Growth,     ///< all lengths of the arm by the same share, as it is warmer or colder: 1
};

/// A change that points might show.
struct PossibleChange {
  DriftCauseKind kind;
  int index;              ///< of the reflector, the joint or the point, from 0
  std::vector<int> free;  ///< parameters that it moves (ParameterLayout); none for a reading
};

/// The base, the reflectors that were measured, and the joints' zeros.
std::vector<PossibleChange> changes_of_cell(const CalibratedCell& cell, std::span<const Measurement> points);
/// All lengths by one share.
PossibleChange growth_of(const CalibratedCell& cell);
/// That one of the points is wrong; none of two or fewer, of which none can call another wrong.
std::vector<PossibleChange> wrong_readings(std::span<const Measurement> points);

/// The cell with its base put where the points say by a rigid fit, where they do: a tracker may have been set
/// up anew anywhere.
CalibratedCell with_fitted_base(const CalibratedCell& cell, std::span<const Measurement> points);

/// By how much `change` moved from one cell to the other: of the base (mm; turn about the tracker's axes,
/// rad), the reflector (mm, flange frame) or the joint in its own sense (rad, mm); the others are no matter
/// of a cell's single parameters.
Eigen::VectorXd moved_between(const CalibratedCell& from, const CalibratedCell& to,
                              const PossibleChange& change);

/// "axis 3's zero moved by 0.0120 deg", "the tracker or the base moved by 0.21 mm and 0.0030 deg".
///
/// @param moved   by moved_between(); of a reading mm, tracker frame; of growth the share
/// @param points  of which a reading is one
std::string described(DriftCauseKind kind, int index, const Eigen::VectorXd& moved,
                      const CalibratedCell& cell, std::span<const Measurement> points);

}  // namespace truepose
