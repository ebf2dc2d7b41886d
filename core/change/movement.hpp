#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/change/change_hypothesis.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Something moved while it was measured: a base, a joint's zero, all of them, a reflector or all lengths.
struct Movement : ChangeFound {
  double chance = 1;      ///< at which as much is seen where nothing moved
  std::size_t first = 0;  ///< point after the step, from 0; 0: little by little, from the first to the last
  std::size_t again = 0;  ///< point after a second step, which may lead back; 0: there was none
  int before = 0, before_again = 0;  ///< points measured before each step: of a base those of its station
  double moved_mm = 0;  ///< what it did to the points after it, on average; little by little: to the last
  bool halves = false;  ///< without it less than half is left of the standard deviation
  std::vector<ChangeHypothesis> or_else = {};  ///< explain the points as well
  /// Index of a joint whose own errors explain the points as well: nothing tells which of both it is.
  std::optional<int> or_joint = {};
  bool or_warmth = false;  ///< an arm that warmed up explains the points as well
};

/// Looks for a moment from which on all points are moved as by another base, another zero of a joint or
/// another reflector; for two moments between which, and after which, they are moved as by other bases; for a
/// base or a reflector that moves evenly.
///
/// The identified parameters have taken in a part of such a movement, so they are left free: what their
/// columns cannot explain of the residuals is compared with and without more columns, as the six of the base
/// for the points after the moment. Where the stated noise explains what is left with them, along the beams
/// and across them, and what they took is more than chance, it is a movement. Where a model does not describe
/// all of an arm, neighbours in time that are neighbours in space look alike: there, and where no noise is
/// known or it is more than was stated, these columns must halve the standard deviation (each by its
/// degrees of freedom), and not by chance.
///
/// Where poses were measured in an order that a joint follows, as those of a turntable that is turned in
/// steps, what a joint errs with its angle is much like a movement. The residuals decide: nothing has moved
/// where joint errors clearly explain them better. Both are reported where neither explanation is clearly
/// better.
///
/// @param points  with their times, or in the order in which they were measured, or that one reflector after
///                the other
/// @param far     indices of points that nothing explains: they are left out, unless nearly all
///                from a moment on, or up to it, are such and off in the same way: then it is they that moved
std::optional<Movement> movement(const CalibratedCell& cell, std::span<const Measurement> points,
                                 const std::optional<MeasurementNoise>& stated,
                                 std::span<const std::size_t> far = {});

}  // namespace truepose
