#pragma once

#include "tools/sim/krl/evaluator.hpp"

namespace truepose::sim::krl {

/// Carries out an operator: takes its operands from the stack and leaves the result there.
/// Throws Fault without file and line: division by zero, a number that does not fit into its type.
/// @pre it is an operator
void operate(const Instruction& instruction, const Program& program, Evaluator& evaluator);

/// As a REAL variable holds it: 32 bits.
double to_real(double number);

}  // namespace truepose::sim::krl
