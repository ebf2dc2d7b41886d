#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "config/table/csv_reader.hpp"
#include "core/data/measurement.hpp"

namespace truepose::config {

/// How a 6-D target is turned: a, b, c, KUKA's angles (deg) of its axes in the tracker frame, and sigma_abc
/// (deg), the standard uncertainty of the turn about each axis.
inline constexpr std::array<std::string_view, 4> kTurnColumns{"a", "b", "c", "sigma_abc"};

/// Those columns of a table, which are there together or not at all; in a row they may be empty, all four.
class TurnColumns {
 public:
  /// Throws ConfigError.
  explicit TurnColumns(const CsvTable& table);
  /// Throws ConfigError for what is no angle and no sigma.
  std::optional<MeasuredOrientation> at(std::size_t row) const;

 private:
  const CsvTable& table_;
  std::vector<std::size_t> columns_;
};

/// The four fields of a row, divided by commas; all empty of none.
std::string turn_fields(const std::optional<MeasuredOrientation>& orientation);

}  // namespace truepose::config
