#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// What of a calibrated cell may have changed: since its calibration, or while it was measured.
enum class ChangeKind {
  Base,         ///< the tracker or the base moved, which look alike: 6 unknowns
  Reflector,    ///< sits elsewhere on the flange, or is another one: 3
  JointZero,    ///< the encoder of a joint reads another angle: 1
  Reading,      ///< one point is wrong, its 3 coordinates tell nothing
  Growth,       ///< all lengths of the arm by the same share, as it is warmer or colder: 1
  Link,         ///< one length or angle of one link: 1
  AllZeros,     ///< the encoders of all joints read other angles, as after mastering: 1 a joint
  Load,         ///< what the flange carries, which bends the joints: 1 a joint that turns
  WarmUp,       ///< the zeros of all joints and all lengths, as of an arm that warms up: 1 a joint and 1
  JointErrors,  ///< what a joint errs with its own angle, in each entry of its link: 10 a harmonic
  Pose,         ///< one pose that is measured again and again does not stay, whatever changed: 3
};
struct Change {
  ChangeKind kind = ChangeKind::Base;
  int index = 0;  ///< of the station, reflector, joint or point, from 0; of a link its parameter

  bool operator==(const Change&) const = default;
};

/// Whether a point shows a change of the cell: that of a base where it was measured from its station, that of
/// a reflector where it was measured with it, all others always.
bool shows(const Measurement& point, const Change& change);

/// A change and the parameters that it moves.
struct PossibleChange {
  Change what;
  std::vector<int> free;  ///< ParameterLayout; none for a reading
};

/// One for each station.
std::vector<PossibleChange> bases_of(const CalibratedCell& cell);
std::vector<PossibleChange> reflectors_of(const CalibratedCell& cell);
std::vector<PossibleChange> joint_zeros_of(const CalibratedCell& cell);
/// The zeros of all joints at once.
PossibleChange all_zeros_of(const CalibratedCell& cell);
/// All lengths by one share.
PossibleChange growth_of(const CalibratedCell& cell);
/// Each link's lengths and angles, but what is the base's place, a reflector's or a joint's zero.
std::vector<PossibleChange> link_parameters_of(const CalibratedCell& cell);
/// That one of the points is wrong; none of two or fewer, of which none can call another wrong.
std::vector<PossibleChange> wrong_readings(std::span<const Measurement> points);

/// Base, reflectors and joints' zeros, where a point shows them.
std::vector<PossibleChange> shown_changes(const CalibratedCell& cell, std::span<const Measurement> points);

/// The cell with its base from a rigid fit to the points, where that is possible: a tracker may have been set
/// up again at any place.
CalibratedCell with_fitted_base(const CalibratedCell& cell, std::span<const Measurement> points);

/// By how much `change` moved from one cell to the other: of the base (mm; turn about the tracker's axes,
/// rad), the reflector (mm, flange frame) or the joint in its own sense (rad, mm); the others are no matter
/// of a cell's single parameters.
Eigen::VectorXd moved_between(const CalibratedCell& from, const CalibratedCell& to, const Change& change);

/// How the changes' unknowns move the parameters: a column each for a mm, a mrad or a thousandth of all
/// lengths, which one metre away are much the same; zero for a reading.
Eigen::MatrixXd directions_of(std::span<const PossibleChange> changes, const CalibratedCell& cell);
/// What one of each of a change's unknowns is: a mm in mm, a mrad in rad, a thousandth of all lengths.
Eigen::VectorXd units_of(const PossibleChange& change, const CalibratedCell& cell);

}  // namespace truepose
