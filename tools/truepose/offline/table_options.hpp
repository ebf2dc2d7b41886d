#pragma once

#include <string>
#include <vector>

#include "config/table/table_reading.hpp"
#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// How a command reads tables that other programs wrote, as the command line says it.
struct TableOptions {
  std::vector<std::string> columns{};
  std::string units{};
};

Option columns_option(TableOptions& options);
Option units_option(TableOptions& options);

/// What was read how is said on standard error.
config::TableReading reading_of(const TableOptions& options);

}  // namespace truepose::tools
