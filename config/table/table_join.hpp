#pragma once

#include <optional>
#include <string>
#include <utility>

#include "config/table/csv_reader.hpp"

namespace truepose::config {

/// Joints and points of the same poses in two files, as tables in truepose's own form with key columns
/// (kKeyPrefix) and perhaps pose and time.
struct TwoTables {
  const CsvTable &joints, &points;
  std::string joints_name, points_name;  ///< of the files, in messages
};

/// Before the name of a column by which rows are joined: "key:point".
inline constexpr const char* kKeyPrefix = "key:";

/// One table: for each point the joints of the row that has the same name, number or time. Of names of
/// SpatialAnalyzer the part behind the last :: counts, and p12 goes with the number 12.
///
/// @return the table and how it was joined
/// Throws ConfigError where no column joins them, where two columns join them differently, or where the
/// joints of a row are not the only ones of its name.
std::pair<CsvTable, std::string> joined(const TwoTables& tables);

}  // namespace truepose::config
