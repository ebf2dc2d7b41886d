#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/sim/krl/value.hpp"

namespace truepose::sim::krl {

/// Carries out a function of the interpreter's own: SQRT, SIN, STRADD, SWRITE ... (standard.cpp declares
/// them).
/// @param arguments  of the declared types; those that are OUT are changed
/// Throws Fault without file and line.
Value call_builtin(std::string_view name, std::vector<Value>& arguments);

/// SWRITE: writes values into a text from an offset on; the offset then stands behind them.
/// @param arguments  CHAR array, STATE_T, INT, format, values
void write_string(std::vector<Value>& arguments);

/// SREAD: reads values out of a text from an offset on; the offset then stands behind them.
/// @param arguments  text, STATE_T, INT, format, and each variable with its type: INT, REAL, BOOL, CHAR or,
///                   of a CHAR array, TEXT
void read_string(std::vector<Value>& arguments);

}  // namespace truepose::sim::krl
