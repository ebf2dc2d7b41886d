#include "tools/sim/krl/memory.hpp"

#include "tools/sim/krl/evaluator.hpp"

namespace truepose::sim::krl {

Memory::Memory(const Program& program) {
  for (const Variable& variable : program.globals) globals.push_back(program.types.blank(variable.type));
  Evaluator(program, globals, nullptr).execute_all(program.initial_values);
}

}  // namespace truepose::sim::krl
