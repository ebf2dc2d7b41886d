#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>
#include <vector>

#include "proto/krl/hindrance_kinds.hpp"
#include "proto/krl/program.hpp"
#include "proto/krl/program_statement.hpp"

namespace truepose::krl {

/// Tool, base and interpolation of an inline form: `DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,...}`.
struct MotionData {
  std::optional<int> tool, base;  ///< numbers in TOOL_DATA and BASE_DATA
  bool fixed_tool = false;        ///< IPO_FRAME #TCP
};

enum class VariableType {
  Position,    ///< POS, E6POS, AXIS, E6AXIS
  Frame,       ///< FRAME
  MotionData,  ///< FDAT
};

/// A declared variable that can say where the arm goes.
struct Variable {
  std::string_view name;  ///< as declared
  VariableType type = VariableType::Position;
  Spot declared;
  bool array = false;
  bool is_element = false;                                   ///< of an array that is declared too
  std::variant<std::monostate, Position, MotionData> value;  ///< none: none given, or not a whole one
  std::shared_ptr<const Hindrance>
      hindrance;  ///< why a motion to it has no value of the text; rare and large
};

/// Where a name is used.
struct Scope {
  std::string_view module;  ///< in capitals
  std::size_t routine = 0;  ///< number of its DEF or DEFFCT in the SRC, the first = 1; 0: the data list
};

/// What programs and their data lists declare. A variable, or an element of an array, may be given one value,
/// where it is declared or by one assignment; what is assigned again, changed in part or handed to a routine
/// is marked by a hindrance.
class Variables {
 public:
  /// Reads the declarations of a file. Its module's name and its text outlive the variables. Throws Fault: a
  /// variable declared twice.
  void read_declarations(const SourceText& source, std::size_t file, const TextStatements& statements);
  /// Reads its assignments and calls, once all declarations are read.
  void read_uses(const SourceText& source, std::size_t file, const TextStatements& statements);

  /// @return an index into all(), or nothing where the name is declared elsewhere
  std::optional<std::size_t> find(std::string_view name, Scope scope) const;
  /// The same of `NAME[1]` or `NAME[2,1]` with plain numbers.
  /// @return nothing where it is none of these or was given no value
  std::optional<std::size_t> find_element(const Expression& element, Scope scope) const;

  const std::vector<Variable>& all() const { return variables_; }

  /// The first statement of the module's SRC that writes an element of TOOL_DATA or BASE_DATA, in whole or in
  /// part. One whose index is no number may write any. The controller keeps what was written, so that it
  /// counts for all of the text: what stands before it is carried out again.
  std::optional<Spot> frame_written(std::string_view module, std::string_view table, int number) const;

 private:
  void declare(const Declaration& declaration, Scope scope, std::size_t file, bool is_global);
  void read_assignment(const Assignment& assignment, Scope scope, std::size_t file);
  void read_frame_write(const Expression& variable, Scope scope, std::size_t file);
  void read_arguments(const Expression& call, Scope scope, std::size_t file);
  void read_chosen_element(const Expression& variable, Scope scope, std::size_t file);
  void give_element(std::size_t array, const Assignment& assignment, Spot spot);
  void hinder_elements(std::size_t array, const Message& why, Spot spot);

  std::vector<Variable> variables_;
  std::map<std::pair<std::size_t, std::string>, std::size_t> elements_;  // by array and "1" or "2,1"
  // By module and table; no index: any element.
  std::map<std::tuple<std::string, std::string, std::optional<int>>, Spot> frame_writes_;
  // By module, routine and name in capitals; those that all modules know have no module.
  std::map<std::tuple<std::string, std::size_t, std::string>, std::size_t, std::less<>> names_;
};

/// Reads `{TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}`.
MotionData motion_data_of(const Expression& aggregate);

}  // namespace truepose::krl
