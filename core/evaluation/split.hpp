#pragma once

#include <cstdint>

#include "core/calibration/measurement.hpp"

namespace truepose {

/// Marks part of the poses to identify and the rest to validate. Points with the same joints are one pose and
/// stay together, so that no validation pose has been seen by the identification.
///
/// Poses are numbered in the order of first appearance and shuffled by Fisher and Yates: for i = P - 1 down
/// to 1, swap pose i with pose n mod (i + 1), n the next number of SplitMix64 begun with the seed. The first
/// round(fraction * P) identify.
///
/// @param fraction  of the poses that identify, 0 to 1
void split_poses(MeasurementData& data, double fraction, std::uint64_t seed);

/// Marks the poses of one fold of a K-fold cross-validation to validate and all others to identify. The poses
/// are shuffled as in split_poses(), and the one at place n belongs to fold n mod K: over all folds every
/// pose validates once, and folds differ by one pose at most.
///
/// @param folds  K, at least 2
/// @param fold   0 to K - 1
void hold_out_fold(MeasurementData& data, int folds, int fold, std::uint64_t seed);

}  // namespace truepose
