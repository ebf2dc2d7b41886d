#include "tools/sim/krl/symbols.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace truepose::sim::krl {
namespace {

/// Simple values that one variable may hold; the controller's memory is of that order.
constexpr long kLargestVariable = 1'000'000;

constexpr std::size_t kLongestName = 24;

constexpr auto kKeywords = std::to_array<std::string_view>(
    {"AND",     "BOOL",       "BRAKE",     "B_AND",    "B_EXOR", "B_NOT",  "B_OR",     "CASE",
     "CHAR",    "CIRC",       "CONST",     "CONTINUE", "DECL",   "DEF",    "DEFAULT",  "DEFDAT",
     "DEFFCT",  "DO",         "ELSE",      "END",      "ENDDAT", "ENDFCT", "ENDFOR",   "ENDIF",
     "ENDLOOP", "ENDSPLINE",  "ENDSWITCH", "ENDWHILE", "ENUM",   "EXIT",   "EXOR",     "EXT",
     "EXTFCT",  "FALSE",      "FOR",       "GLOBAL",   "GOTO",   "HALT",   "IF",       "IMPORT",
     "INT",     "INTERRUPT",  "LIN",       "LIN_REL",  "LOOP",   "NOT",    "OR",       "PTP",
     "PTP_REL", "PTP_SPLINE", "PUBLIC",    "REAL",     "REPEAT", "RESUME", "RETURN",   "SCIRC",
     "SIGNAL",  "SLIN",       "SLIN_REL",  "SPL",      "SPLINE", "SPTP",   "SPTP_REL", "STRUC",
     "SWITCH",  "THEN",       "TRIGGER",   "TRUE",     "UNTIL",  "WAIT"});

const std::vector<std::size_t>& slots_of(const auto& slots, std::string_view name) {
  static const std::vector<std::size_t> kNone;
  const auto at = slots.find(std::string{name});
  return at == slots.end() ? kNone : at->second;
}

}  // namespace

std::optional<std::size_t> Program::find_routine(std::string_view name) const {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < routines.size(); ++i) {
    if (routines[i].name != name) continue;
    if (routines[i].is_global) return i;
    if (!found) found = i;
  }
  return found;
}

std::optional<std::size_t> Program::find_system(std::string_view name) const {
  const auto found = std::ranges::find(systems, name, &Variable::name);
  return found == systems.end() ? std::nullopt
                                : std::optional{static_cast<std::size_t>(found - systems.begin())};
}

int Symbols::module_of(const std::string& name) {
  const auto at = std::ranges::find(modules_, name);
  if (at != modules_.end()) return static_cast<int>(at - modules_.begin());
  modules_.push_back(name);
  return static_cast<int>(modules_.size()) - 1;
}

int Symbols::add_file(const std::string& file) {
  program.files.push_back(file);
  return static_cast<int>(program.files.size()) - 1;
}

std::optional<Symbol> Symbols::find_variable(std::string_view name, int module) const {
  for (const std::size_t slot : slots_of(systems_, name)) {
    const Variable& variable = program.systems[slot];
    return Symbol{Storage::System, slot, variable.type, variable.is_constant, variable.passes_advance_run};
  }
  std::optional<Symbol> found;
  for (const std::size_t slot : slots_of(signals_of_, name)) {
    const Signal& signal = signals_[slot];
    if (signal.module == module || signal.is_global) found = signal.symbol;
  }
  for (const std::size_t slot : slots_of(globals_, name)) {
    const Variable& variable = program.globals[slot];
    const bool is_own = variable.module == module;
    if (!is_own && !variable.is_global) continue;
    found = Symbol{Storage::Global, slot, variable.type, variable.is_constant, true};
    if (is_own) break;
  }
  return found;
}

std::optional<std::size_t> Symbols::find_routine(std::string_view name, int module) const {
  std::optional<std::size_t> found;
  for (const std::size_t slot : slots_of(routines_, name)) {
    const Routine& routine = program.routines[slot];
    const bool is_own = routine.module == module;
    if (!is_own && !routine.is_global) continue;
    found = slot;
    if (is_own) break;
  }
  return found;
}

std::optional<std::size_t> Symbols::find_external(std::string_view name) const {
  const std::vector<std::size_t>& slots = slots_of(externals_, name);
  return slots.empty() ? std::nullopt : std::optional{slots[0]};
}

Symbol Symbols::add_variable(const Variable& variable, const TokenReader& reader) {
  check_new_name(variable.name, reader);
  for (const std::size_t slot : slots_of(globals_, variable.name)) {
    const Variable& other = program.globals[slot];
    const bool meets = other.module == variable.module || (other.is_global && variable.is_global);
    if (meets) reader.fail(variable.name + " is declared twice");
  }
  globals_[variable.name].push_back(program.globals.size());
  program.globals.push_back(variable);
  return *find_variable(variable.name, variable.module);
}

Symbol Symbols::add_system(const Variable& variable, const TokenReader& reader) {
  check_new_name(variable.name, reader);
  if (systems_.contains(variable.name)) reader.fail(variable.name + " is declared twice");
  systems_[variable.name].push_back(program.systems.size());
  program.systems.push_back(variable);
  if (variable.type.is_array()) program.systems.back().element = variable.type.element();
  return *find_variable(variable.name, variable.module);
}

void Symbols::add_signal(Signal signal, const TokenReader& reader) {
  check_new_name(signal.name, reader);
  if (find_variable(signal.name, signal.module)) reader.fail(signal.name + " is declared twice");
  signals_of_[signal.name].push_back(signals_.size());
  signals_.push_back(std::move(signal));
}

void Symbols::add_routine(Routine routine) {
  for (const std::size_t slot : slots_of(routines_, routine.name)) {
    const Routine& other = program.routines[slot];
    const bool meets = other.module == routine.module || (other.is_global && routine.is_global);
    if (meets)
      throw Fault{program.files[static_cast<std::size_t>(routine.file)], routine.line,
                  "the subprogram " + routine.name + " is declared twice"};
  }
  routines_[routine.name].push_back(program.routines.size());
  program.routines.push_back(std::move(routine));
}

void Symbols::add_external(External external) {
  externals_[external.name].push_back(program.externals.size());
  program.externals.push_back(std::move(external));
}

void Symbols::refuse(const Fault& fault, const std::vector<std::string>& names) {
  program.refusals.push_back(fault);
  for (const std::string& name : names) refused_.emplace(name, fault);
}

std::string Symbols::why_unknown(const std::string& name) const {
  const auto refused = refused_.find(name);
  return refused == refused_.end() ? "" : " (" + refused->second.text() + ")";
}

void Symbols::check_new_name(const std::string& name, const TokenReader& reader) const {
  if (std::ranges::find(kKeywords, name) != kKeywords.end())
    reader.fail(name + " is a word of KRL and cannot be a name");
  if (name.size() > kLongestName)
    reader.fail(name + " has more than " + std::to_string(kLongestName) + " characters");
}

bool begins_declaration(const TokenReader& reader, const Types& types) {
  const Token* type = declared_type(reader.rest());
  return reader.next_is("DECL") || (type && types.find(type->word()));
}

Direction read_direction(TokenReader& reader) {
  if (!reader.take_if(":")) return Direction::Out;
  const std::string direction = reader.take_name("IN or OUT");
  if (direction != "IN" && direction != "OUT") reader.fail("IN or OUT is expected instead of " + direction);
  return direction == "IN" ? Direction::In : Direction::Out;
}

Type type_of(const Token& name, const TokenReader& reader, const Types& types) {
  const auto type = name.kind == TokenKind::Name ? types.find(name.word()) : std::nullopt;
  if (!type) reader.fail("the type " + name.word() + " is not known");
  return *type;
}

Type sized(Type type, std::vector<int> sizes, const TokenReader& reader, const Types& types) {
  type.sizes = std::move(sizes);
  if (types.size(type, kLargestVariable) > kLargestVariable) reader.fail("the variable is too large");
  return type;
}

}  // namespace truepose::sim::krl
