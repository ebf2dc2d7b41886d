#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/sim/krl/symbols.hpp"

namespace truepose::sim::krl {

/// Where code is written to while one subprogram is compiled, and what its names stand for.
struct Scope {
  Symbols& symbols;
  int module = 0;
  int file = 0;
  std::vector<Field> locals = {};
  int line = 0;               ///< of the statement in work
  bool is_continued = false;  ///< CONTINUE stands before the statement: it does not stop the advance run
  /// What is executed outside the program's sequence, empty for the program: the condition of an "interrupt",
  /// what a "trigger" sets. It has no local data and calls nothing.
  std::string_view aside = {};
  bool is_submit = false;  ///< of a .sub: it must not move the arm

  std::size_t emit(Op op, std::size_t a = 0, std::size_t b = 0);
  /// Turns the place that was written from `before` on into its value.
  void fetch(std::size_t before);
  /// Of the place of a system variable's element, whose index stands in the program.
  std::optional<std::int32_t> constant_index(std::span<const Instruction> place) const;
  /// The arm must have come so far, unless CONTINUE says otherwise.
  void stop_advance_run();
  /// Lets the jump at `at` lead to what is written next.
  void land(std::size_t at) {
    symbols.program.code[at].a = static_cast<std::int32_t>(symbols.program.code.size());
  }
  std::size_t here() const { return symbols.program.code.size(); }
  void push(Value constant);
  /// A local variable that no name stands for. @return its slot
  std::size_t add_hidden(Type type);

  /// Errors: the name is not known.
  Symbol variable(const std::string& name) const;
  Types& types() const { return symbols.program.types; }
  [[noreturn]] void fail(const std::string& what) const;
  /// Takes back the code from `before` on: what stands there is not known, and stops the program.
  void refuse(std::size_t before, const Fault& fault);
};

}  // namespace truepose::sim::krl
