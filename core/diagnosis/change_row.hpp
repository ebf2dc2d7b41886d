#pragma once

#include <cstddef>
#include <vector>

namespace truepose {

/// Where one explanation of the rows of a file gives way to another.
struct ChangeRow {
  std::size_t row = 0;  ///< the first row of the later explanation
  double cost = 0;      ///< the misses of all rows, each by its explanation and capped
};

/// The row from which on `later` fits better and before which `earlier` does. A row counts no more than some
/// times the median of the better fits, thus outliers do not decide.
///
/// @param earlier, later  misses of each row, mm
ChangeRow change_between(const std::vector<double>& earlier, const std::vector<double>& later);

}  // namespace truepose
