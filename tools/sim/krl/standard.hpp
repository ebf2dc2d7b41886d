#pragma once

#include <string_view>

namespace truepose::sim::krl {

/// KRL of what every controller declares: the geometric structures, the state of a variable and of a text,
/// the variables that motions are made with, and the functions that the interpreter has itself.
std::string_view standard_declarations();

/// Whether the advance run continues over a system variable: those that motions take with them, as the manual
/// has it. All others are read and written when the arm has come so far.
bool passes_advance_run(std::string_view system_variable);

}  // namespace truepose::sim::krl
