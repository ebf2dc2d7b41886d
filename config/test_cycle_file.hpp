#pragma once

#include <filesystem>
#include <vector>

#include "config/text_file.hpp"
#include "core/quality/iso9283.hpp"

namespace truepose::config {

struct TableReading;

/// Reads the cycles of an ISO 9283 test (CSV with a header row, any column order): `point` (P1), `cycle`,
/// `x,y,z` (mm); optional `a,b,c` (KUKA's angles, deg), `smr` (name of the reflector), `direction` (from
/// which the pose was approached) and `time` (of a series of cycles: the same text in all its rows; left out
/// of the result where there is one series alone).
///
/// Commanded poses are in `targets` (CSV: point,x,y,z, optional a,b,c and smr) or, where that is empty, in
/// columns cx,cy,cz (ca,cb,cc) of the data. Several reflectors make one pose each cycle: its position is the
/// mean of theirs, its orientation the turn that brings their commanded positions nearest to the measured
/// ones.
///
/// @param reading  of files that other programs wrote too; null: in this form only
/// @return all commanded points in the order of their names, poses as measured: none where no cycle came to a
/// point
/// Throws ConfigError naming file, row and column.
std::vector<TestPoint> load_test_cycles(const std::filesystem::path& data,
                                        const std::filesystem::path& targets,
                                        const TableReading* reading = nullptr);

}  // namespace truepose::config
