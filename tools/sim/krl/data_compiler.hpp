#pragma once

#include <string>
#include <vector>

#include "tools/sim/krl/statement_reader.hpp"
#include "tools/sim/krl/symbols.hpp"

namespace truepose::sim::krl {

/// Adds the structures and enumerations, which other lists may use whatever their order. Throws Fault.
void collect_types(const ModuleFile& list, Symbols& symbols);

/// Adds the variables, and writes code that gives them their initial values. Throws Fault.
void compile_data(const ModuleFile& list, Symbols& symbols, const std::vector<std::string>& pass_advance_run);

}  // namespace truepose::sim::krl
