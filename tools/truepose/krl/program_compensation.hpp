#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/arm/status_turn.hpp"
#include "core/compensate/target_compensation.hpp"
#include "proto/krl/program.hpp"
#include "proto/krl/rewrite.hpp"

namespace truepose::tools {

/// How far a position of the program was moved: the TCP in its base; the flange for a position given in axes.
struct PointChange {
  krl::Spot spot;
  std::string name;  ///< empty where it is written in the motion itself
  double mm = 0;
  double deg = 0;
};

/// What becomes of the positions of a program.
struct ProgramCompensation {
  std::map<std::size_t, std::vector<krl::Edit>>
      edits;               ///< by file of the ProgramText; files without any are not in it
  std::size_t points = 0;  ///< that motions go to and that the texts tell
  std::vector<PointChange> changes;
  std::vector<krl::LeftAlone> left;
  std::vector<krl::Note> notes;
};

/// Where a tool and a base of the program truly are, by their numbers: the tool on the calibrated arm's
/// flange.
struct RealFrames {
  std::map<int, Eigen::Isometry3d> tools, bases;
};

/// Moves the positions of a program so that the calibrated arm stands where the nominal one would have: for
/// each the joints that the controller would find, from there the joints of the calibrated arm, and the
/// position that makes the controller come to these. S and T follow where an axis crosses their boundary.
/// They count for LIN and CIRC too, though the controller looks at them in PTP alone: the position was taught
/// at them.
///
/// A position is left alone where it is out of reach or beyond a joint limit, where the correction is too
/// large to be one, and where two motions use it with different tools or bases.
/// @param inverse  of `nominal`
/// @param is_archive  a motion whose tool or base is not known is left alone too
/// @param real     of frames that are not where the program has them
/// Errors: a Cartesian motion whose tool or base is not known.
std::expected<ProgramCompensation, krl::ProgramFault> compensate_program(
    const krl::Program& program, const RobotModel& nominal, const StatusTurnInverse& inverse,
    const RobotModel& calibrated, const CompensationOptions& bounds = {}, const RealFrames& real = {},
    bool is_archive = false);

}  // namespace truepose::tools
