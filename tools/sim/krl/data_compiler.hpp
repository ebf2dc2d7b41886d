#pragma once

#include <string>
#include <vector>

#include "tools/sim/krl/statement_reader.hpp"
#include "tools/sim/krl/symbols.hpp"

namespace truepose::sim::krl {

/// A data list: a .dat, or the declarations of the environment.
struct DataList {
  std::string name;  ///< of the file, for messages
  std::vector<Statement> statements;
  int module = 0;
  int file = 0;
  bool is_environment = false;  ///< without DEFDAT and ENDDAT; all of it is known to all, and EXT declares
  bool is_global = false;       ///< all of its data is known to all modules
  bool is_partial = false;      ///< as Source::is_partial
};

/// Adds the structures and enumerations, which other lists may use whatever their order. Throws Fault.
void collect_types(const DataList& list, Symbols& symbols);

/// Adds the variables, and writes code that gives them their initial values. Throws Fault.
void compile_data(const DataList& list, Symbols& symbols, const std::vector<std::string>& pass_advance_run);

}  // namespace truepose::sim::krl
