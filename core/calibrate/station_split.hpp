#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/data/measurement.hpp"

namespace truepose {

/// Marks part of the poses of each station to identify and the rest to validate, as split_poses() does of
/// all: drawn from all together, the few of a small station might all validate, and nothing would tell where
/// it is. So many of a station's poses identify at least as place it. A pose that several stations saw is
/// drawn once, with those of the station of the fewest poses. Of one station it is split_poses().
///
/// @param fraction  of the poses that identify, 0 to 1
void split_each_station(MeasurementData& data, double fraction, std::uint64_t seed);

/// Marks the poses of one fold to validate as hold_out_fold() does, those of each station spread over all
/// folds.
void hold_out_fold_of_each_station(MeasurementData& data, int folds, int fold, std::uint64_t seed);

/// Which station too few poses to identify are left of to place it, and how many, one clause; nothing where
/// there are enough of all.
std::optional<std::string> unplaced_station(const MeasurementData& marked);

}  // namespace truepose
