#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tools/sim/krl/host.hpp"
#include "tools/sim/krl/symbols.hpp"

namespace truepose::sim::krl {

/// Where a value stands: a variable, and the way to a part of it.
struct Place {
  Storage storage = Storage::Global;
  std::size_t slot = 0;
  std::size_t frame = 0;                                      ///< of a local variable
  boost::container::small_vector<std::int64_t, 2> path = {};  ///< indices and components, from 0
  std::int32_t bits = 0;  ///< not 0: the INT made of so many elements from there on
};

using Operand = std::variant<Value, Place>;

/// The local data of a subprogram that runs.
struct Locals {
  const Routine* routine = nullptr;  ///< null behind an interrupt, whose call has none
  std::vector<Operand> values = {};
};

/// Carries out the instructions that neither wait nor jump. Throws Fault without file and line.
class Evaluator {
 public:
  /// @param host  null where no system variable is used
  Evaluator(const Program& program, std::vector<Value>& globals, Host* host)
      : program_{program}, globals_{globals}, host_{host} {}

  std::vector<Operand> operands;
  std::vector<Locals> locals;  ///< of each frame

  void execute(const Instruction& instruction);
  /// Executes from `at` to Done. Its Fault has file and line.
  void execute_all(std::size_t at);

  void push(Value value) { operands.emplace_back(std::move(value)); }
  Value pop();
  Place pop_place();
  bool pop_bool() { return std::get<bool>(pop()); }
  std::int32_t pop_int() { return std::get<std::int32_t>(pop()); }

  /// @return not set where the variable never got a value
  Value look(const Place& place);
  void store(const Place& place, Value value);

 private:
  /// A system variable, or an element of it with its index from 1, and what is left of the way to its part.
  struct Asked {
    const Variable& variable;
    std::optional<int> index;
    const Type& type;
    std::span<const std::int64_t> path;
  };
  Asked asked_of_host(const Place& place) const;

  /// @return false where it is no such instruction
  bool execute_place(const Instruction& instruction);
  Value fetch(const Place& place);
  void push_set(const Value& value, const Place& place);
  /// Errors: Fault where the value is not set. @param place  where it stands
  void check_set(const Value& value, const Place& place) const;
  Value look_at_system(const Place& place);
  /// What the host has, of the type that is declared. @param place  for messages
  Value asked_for(const Variable& variable, std::optional<int> index, const Type& type, const Place& place);
  void store_in_system(const Place& place, Value value);
  Value look_at_bits(const Place& place);
  void store_bits(const Place& place, std::uint32_t number);
  Field root_of(const Place& place) const;
  std::string describe(const Place& place) const;
  void gather(const Instruction& instruction);

  const Program& program_;
  std::vector<Value>& globals_;
  Host* host_;
};

/// Sets a part of a value. @param path  to it: indices and components, from 0
/// Errors: Fault where the path leaves it, or a text has no room.
void set_part(Value& whole, std::span<const std::int64_t> path, Value value);

/// Whether a value may stand in a variable of that type; one that is not set may.
bool has_type(const Value& value, const Type& type, const Types& types);

}  // namespace truepose::sim::krl
