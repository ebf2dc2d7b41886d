#pragma once

#include <cstddef>

#include "config/table/foreign_table.hpp"
#include "config/table/table_reading.hpp"

namespace truepose::config {

/// What one of a column's unit is in deg or mm, by its name, the row below it or --units. Throws ConfigError
/// where they contradict each other or the column, and for a unit that is not read.
double factor_of(const ForeignTable& table, std::size_t column, const TableForm& form,
                 const TableReading& reading);

/// A number that was converted to deg or mm, as it is. Throws ConfigError where no arm can have it.
double converted(double value, const ForeignTable& table, std::size_t row, std::size_t column,
                 const TableForm& form);

/// Refuses joints or coordinates of which some say another unit than deg and mm, and some say none.
void expect_units_of_all(const ForeignTable& table);

}  // namespace truepose::config
