#pragma once

#include "core/judge/path_accuracy.hpp"

namespace truepose::report {

/// The program GLUING in the plane z = 500 mm: 400 mm along x, then 200 mm along y, at 0.25 m/s, the arm two
/// samples behind. Along the path the TCP is off by 0.05 mm with the correction and 1.5 mm without it; at its
/// two points by 0.1 and 0.2 mm, and 2 and 1 mm without it.
ProductionPath sample_path();

}  // namespace truepose::report
