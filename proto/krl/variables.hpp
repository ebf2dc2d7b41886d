#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

#include "proto/krl/position.hpp"

namespace truepose::krl {

/// Tool, base and interpolation of an inline form: `DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,...}`.
struct MotionData {
  std::optional<int> tool, base;  ///< numbers in TOOL_DATA and BASE_DATA
  bool fixed_tool = false;        ///< IPO_FRAME #TCP
};

/// Why the text does not tell the value of a variable where a motion uses it.
struct Hindrance {
  std::string why;
  std::optional<Spot> because;  ///< the statement that does it
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
  std::variant<std::monostate, Position, MotionData> value;  ///< none: none given, or not a whole one
  std::optional<Hindrance> hindrance;
};

/// What a program and its data list declare. A variable may be given one value, where it is declared or by
/// one assignment; what is assigned again, changed in part or handed to a routine is marked by a hindrance.
class Variables {
 public:
  /// Reads the declarations and assignments of a file. The text outlives the variables.
  /// Errors: a faulty aggregate or number in one of them; a variable declared twice.
  std::expected<void, Fault> read(std::string_view text, File file);

  /// @param routine  number of the DEF or DEFFCT that uses the name, in the order of the SRC, the first = 1
  /// @return an index into all(), or nothing where the name is declared elsewhere
  std::optional<std::size_t> find(std::string_view name, std::size_t routine) const;

  const std::vector<Variable>& all() const { return variables_; }

  /// The first statement of the SRC that writes an element of TOOL_DATA or BASE_DATA, in whole or in part.
  /// One whose index is no number may write any. The controller keeps what was written, so that it counts
  /// for all of the text: what stands before it is carried out again.
  std::optional<Spot> frame_written(std::string_view table, int number) const;

 private:
  std::expected<void, Fault> read_declaration(Tokens statement, File file, std::size_t routine);
  std::expected<void, Fault> read_assignment(Tokens statement, File file, std::size_t routine);
  void read_frame_write(Tokens variable, Spot spot);
  void read_arguments(Tokens statement, File file, std::size_t routine);
  std::expected<void, Fault> give_value(Variable& variable, Tokens value, Spot spot);

  std::vector<Variable> variables_;
  std::map<std::pair<std::string, std::optional<int>>, Spot> frame_writes_;  // no index: any element
  // By name in capitals: those of the data list first, then those of each routine.
  std::vector<std::unordered_map<std::string, std::size_t>> scopes_{1};
};

/// Whether a statement starts a routine: [GLOBAL] DEF or DEFFCT.
bool starts_routine(Tokens statement);

/// The statement that TRIGGER ... DO or INTERRUPT ... DO carries out later, or the statement itself.
Tokens action_of(Tokens statement);

/// Reads `{TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}`.
MotionData motion_data_of(const Aggregate& aggregate);

/// Index behind the variable that starts at tokens[from]: its name, indices and components.
std::size_t end_of_variable(Tokens tokens, std::size_t from);

}  // namespace truepose::krl
