#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/data/measurement.hpp"

namespace truepose {

/// Indices of the points as they were measured: by their times where all tell them, else as they stand. All
/// reflectors of a pose were measured at one stop, though they may stand one reflector after the other.
/// Points of which neither says when they were measured are left out.
std::vector<std::size_t> measured_order(std::span<const Measurement> points);

/// Points that one stop of the arm shows: of one pose and station, one after the other.
std::vector<std::vector<std::size_t>> stops_of(std::span<const Measurement> points);

/// How many reflectors a stop has, on average.
double points_per_stop(std::span<const Measurement> points);

}  // namespace truepose
