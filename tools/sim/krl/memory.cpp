#include "tools/sim/krl/memory.hpp"

#include "tools/sim/krl/evaluator.hpp"

namespace truepose::sim::krl {

Memory::Memory(const Program& program) {
  for (const Variable& variable : program.globals) globals.push_back(program.types.blank(variable.type));
  Evaluator evaluator(program, globals, nullptr);
  for (std::size_t at = program.initial_values; program.code[at].op != Op::Done; ++at) {
    try {
      evaluator.execute(program.code[at]);
    } catch (Fault& fault) {
      fault.file = program.files[static_cast<std::size_t>(program.code[at].file)];
      fault.line = program.code[at].line;
      throw;
    }
  }
}

}  // namespace truepose::sim::krl
