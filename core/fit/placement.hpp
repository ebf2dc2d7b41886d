#pragma once

#include <span>
#include <string>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/fit/least_squares_problem.hpp"

namespace truepose {

/// Near: only next to the minimum over all M, where the best minimum is if the arm is right; for a first look
/// at an arm that may be wrong.
enum class PlacementSearch { Everywhere, Near };

/// Where the base stands and where the reflectors sit with the least squared error, the arm held at `arm`:
/// without any guess, and the best of all minima.
///
/// With c the measured point, (R_k, p_k) the flange and M the inverse of the base's rotation, the misses
/// M c - s - R_k t - p_k are linear in s, which places the base, and in t of each reflector. Once these are
/// eliminated, the squared error is one quadratic form in the entries of M, whatever the number of points:
/// Newton's steps over the rotations start from its minimum over all M. Where rotations far from there might
/// be better, as with points near one plane or line or a flange that hardly turns, they start from rotations
/// all around as well.
///
/// What the poses do not show of a reflector keeps it near the flange's centre; a turn of the base that they
/// do not show is arbitrary.
/// Source: Briales, Gonzalez-Jimenez, Convex global 3D registration with Lagrangian duality, 2017 (the form).
/// @param points  of every reflector at least one; all alike in weight
CalibratedCell placement(const RobotModel& arm, std::span<const std::string> smr_names,
                         std::span<const Measurement> points,
                         PlacementSearch search = PlacementSearch::Everywhere);

/// What placement() knows of reflectors, for other fits of base and reflectors.
Prior placement_prior(const ParameterLayout& layout);

}  // namespace truepose
