#include "tools/sim/krl/data_compiler.hpp"

#include <algorithm>

#include "tools/sim/krl/expression_compiler.hpp"
#include "tools/sim/krl/standard.hpp"

namespace truepose::sim::krl {
namespace {

Structure read_structure(TokenReader& reader, const Types& types) {
  Structure structure{.name = reader.take_name("the name of the structure")};
  Type type = type_of(reader.take(), reader, types);
  do {
    // A type stands before its first component and holds for those that follow.
    if (reader.peek(1).kind == TokenKind::Name) type = type_of(reader.take(), reader, types);
    const std::string name = reader.take_name("a component");
    if (structure.find(name)) reader.fail("the component " + name + " is declared twice");
    structure.fields.push_back({name, sized(type, read_sizes(reader), reader, types)});
  } while (reader.take_if(","));
  return structure;
}

Enumeration read_enumeration(TokenReader& reader) {
  Enumeration enumeration{.name = reader.take_name("the name of the enumeration")};
  do enumeration.literals.push_back(reader.take_name("a constant"));
  while (reader.take_if(","));
  return enumeration;
}

/// Adds a type. A file may declare again what the controller has, as $config.dat of a real one does.
template <typename T>
void add_type(T type, const ModuleFile& list, TokenReader& reader, Symbols& symbols) {
  if (list.is_partial && symbols.program.types.has(type)) return;
  symbols.check_new_name(type.name, reader);
  if (symbols.program.types.find(type.name)) reader.fail("the type " + type.name + " is declared twice");
  symbols.program.types.add(std::move(type));
}

/// STRUC and ENUM, with or without GLOBAL before them.
bool declares_type(const Statement& statement, std::string_view word) {
  return statement[0].is(word) ||
         (statement[0].is("GLOBAL") && statement.size() > 1 && statement[1].is(word));
}

bool is_constant(const Expression& expression) {
  switch (expression.kind) {
    case ExpressionKind::Constant:
    case ExpressionKind::Literal:
      return true;
    case ExpressionKind::Unary:
    case ExpressionKind::Aggregate:
      return std::ranges::all_of(expression.parts, is_constant);
    default:
      return false;
  }
}

/// @param variable  with its indices and components
bool has_constant_indices(const Expression& variable) {
  if (variable.kind == ExpressionKind::Name) return true;
  return has_constant_indices(variable.parts[0]) &&
         std::all_of(variable.parts.begin() + 1, variable.parts.end(), is_constant);
}

class DataCompiler {
 public:
  DataCompiler(const ModuleFile& list, Symbols& symbols, const std::vector<std::string>& pass_advance_run)
      : list_{list},
        symbols_{symbols},
        pass_advance_run_{pass_advance_run},
        scope_{.symbols = symbols, .module = list.module, .file = list.file, .is_continued = true} {}

  void compile() {
    bool is_open = list_.is_environment, is_closed = false;
    for (const Statement& statement : list_.statements) {
      StatementReader reader(list_.name, statement);
      scope_.line = statement[0].line;
      if (is_closed && list_.is_partial) break;
      if (is_closed) reader.fail("a statement stands behind ENDDAT");
      if (!is_open) {
        reader.expect("DEFDAT");
        reader.take_name("the name of the data list");
        reader.take_if("PUBLIC");
        reader.expect_end();
        is_open = true;
      } else if (reader.next_is("ENDDAT") && !list_.is_environment) {
        is_closed = true;
      } else if (!declares_type(statement, "STRUC") && !declares_type(statement, "ENUM")) {
        list_.is_partial ? try_statement(statement) : read_statement(reader);
      }
    }
    if (!is_closed && !list_.is_environment && !list_.is_partial)
      throw Fault{list_.name, last_line(), "ENDDAT is missing"};
  }

 private:
  int last_line() const { return list_.statements.empty() ? 0 : list_.statements.back()[0].line; }

  void try_statement(const Statement& statement) {
    const std::size_t before = scope_.here();
    try {
      StatementReader reader(list_.name, statement);
      read_statement(reader);
    } catch (const Fault& fault) {
      symbols_.program.code.resize(before);
      symbols_.refuse(fault, declared_names(statement));
    }
  }

  /// All names of a statement that nothing else has.
  std::vector<std::string> declared_names(const Statement& statement) const {
    std::vector<std::string> names;
    for (const Token& token : statement) {
      if (token.kind == TokenKind::Name && !symbols_.find_variable(token.word(), list_.module))
        names.push_back(token.word());
    }
    return names;
  }

  void read_statement(TokenReader& reader) {
    if (reader.next_is("EXT") || reader.next_is("EXTFCT")) return read_external(reader);
    if (reader.next_is("SIGNAL") || reader.peek(1).is("SIGNAL")) return read_signal(reader);
    if (begins_declaration(reader, symbols_.program.types)) return read_declaration(reader);
    if (reader.peek().kind != TokenKind::Name)
      reader.fail("a declaration or an initial value is expected before " + reader.peek().word());
    const auto symbol = symbols_.find_variable(reader.peek().word(), list_.module);
    if (!symbol)
      reader.fail("the name " + reader.peek().word() + " is not known, and no declaration begins with it");
    if (symbol->storage != Storage::Global) {
      if (declares_systems()) return;
      reader.fail(reader.peek().word() + " is the controller's and gets no initial value");
    }
    const auto [target, value] = read_assignment(reader);
    reader.expect_end();
    if (!has_constant_indices(target)) reader.fail("an index in a data list is constant");
    check_constant(value, reader);
    ExpressionCompiler(scope_).initialise(target, value);
  }

  static void check_constant(const Expression& value, const TokenReader& reader) {
    if (!is_constant(value)) reader.fail("an initial value is constant");
  }

  void read_declaration(TokenReader& reader) {
    Declaration declaration;
    truepose::krl::read_declaration(reader, declaration);
    reader.expect_end();
    const Type type = type_of(declaration.type, reader, symbols_.program.types);
    for (const Declaration::Name& name : declaration.names) {
      if (name.value) check_constant(*name.value, reader);
      declare({.name = name.token.word(),
               .type = sized(type, name.sizes, reader, symbols_.program.types),
               .is_constant = declaration.is_constant,
               .is_global = declaration.is_global || list_.is_global,
               .module = list_.module},
              name.value, reader);
    }
  }

  void declare(Variable variable, const std::optional<Expression>& value, const TokenReader& reader) {
    if (std::ranges::count(variable.type.sizes, 0) > 0) reader.fail(variable.name + " needs a size");
    const bool is_system = variable.name.starts_with('$');
    if (is_system && !declares_systems())
      reader.fail(variable.name + " begins with $, as the controller's own variables do");
    variable.passes_advance_run = passes(variable.name) || passes_advance_run(variable.name);
    if (is_answered(variable.name)) return;
    const bool is_hosts = is_system && list_.is_environment;
    const Symbol symbol =
        is_hosts ? symbols_.add_system(variable, reader) : symbols_.add_variable(variable, reader);
    if (value) initialise(symbol, variable.name, *value);
  }

  /// Machine data and $config.dat of a real controller declare variables that begin with $.
  bool declares_systems() const {
    return list_.is_environment || symbols_.module_name(list_.module).starts_with('$');
  }

  /// What the controller itself declares, a file of a real one may declare again: its value is the host's.
  bool is_answered(const std::string& name) const {
    if (list_.is_environment) return false;
    const auto symbol = symbols_.find_variable(name, list_.module);
    return symbol &&
           (symbol->storage == Storage::System || (list_.is_partial && symbols_.is_environments(*symbol)));
  }

  /// SIGNAL GRIPPER $OUT[3]; SIGNAL WORD $IN[1] TO $IN[8]
  void read_signal(TokenReader& reader) {
    const bool is_global = reader.take_if("GLOBAL") || list_.is_global;
    reader.expect("SIGNAL");
    Signal signal{
        .name = reader.take_name("the name of the signal"), .module = list_.module, .is_global = is_global};
    if (is_answered(signal.name)) return;
    // SIGNAL $COLL_ALARM FALSE: nothing is connected.
    if (reader.next_is("TRUE") || reader.next_is("FALSE")) return read_unconnected(signal, reader);
    signal.symbol = read_element(reader);
    if (reader.take_if("TO")) {
      if (signal.symbol.type.kind != Kind::Bool) reader.fail("an analog signal has one element");
      const Symbol last = read_element(reader);
      constexpr std::int32_t kWord = 32;
      signal.symbol.bits = *last.element - *signal.symbol.element + 1;
      if (last.slot != signal.symbol.slot || signal.symbol.bits < 1 || signal.symbol.bits > kWord)
        reader.fail("a signal goes from one element up to another of the same array, 32 at most");
    }
    reader.expect_end();
    symbols_.add_signal(std::move(signal), reader);
  }

  void read_unconnected(const Signal& signal, TokenReader& reader) {
    const Symbol symbol = symbols_.add_variable(
        {.name = signal.name, .type = {Kind::Bool}, .is_global = signal.is_global, .module = signal.module},
        reader);
    const Expression value = read_expression(reader);
    check_constant(value, reader);
    initialise(symbol, signal.name, value);
    reader.expect_end();
  }

  Symbol read_element(TokenReader& reader) {
    const std::string variable = reader.take_name("$IN[...] or $OUT[...]");
    auto symbol = symbols_.find_variable(variable, list_.module);
    const bool is_array = symbol && symbol->storage == Storage::System && symbol->type.sizes.size() == 1;
    if (!is_array || (symbol->type.kind != Kind::Bool && symbol->type.kind != Kind::Real))
      reader.fail(variable + " is no array of BOOL or REAL of the controller");
    reader.expect("[");
    const Token& element = reader.take();
    const bool is_whole = element.kind == TokenKind::Integer;
    if (!is_whole || integer_of(element) < 1 || integer_of(element) > symbol->type.sizes[0])
      reader.fail("the number of " + variable + " is 1 to " + std::to_string(symbol->type.sizes[0]));
    symbol->element = integer_of(element);
    reader.expect("]");
    return *symbol;
  }

  void initialise(const Symbol& symbol, const std::string& name, const Expression& value) {
    if (symbol.storage != Storage::Global) scope_.fail(name + " gets its value from the host");
    scope_.emit(Op::Global, symbol.slot);
    ExpressionCompiler(scope_).value_as(value, symbol.type, "the variable " + name);
    scope_.emit(Op::Store);
  }

  bool passes(const std::string& name) const {
    return std::ranges::find(pass_advance_run_, name) != pass_advance_run_.end();
  }

  void read_external(TokenReader& reader) {
    External external;
    if (reader.take().is("EXTFCT")) external.result = type_of(reader.take(), reader, symbols_.program.types);
    external.name = reader.take_name("the name of a subprogram");
    if (!list_.is_environment) return check_known(external.name, reader);
    external.passes_advance_run = passes(external.name);
    reader.expect("(");
    while (!reader.take_if(")")) {
      if (!external.parameters.empty()) reader.expect(",");
      Parameter parameter{.type = type_of(reader.take(), reader, symbols_.program.types)};
      parameter.type = sized(parameter.type, read_sizes(reader), reader, symbols_.program.types);
      parameter.direction = read_direction(reader);
      external.parameters.push_back(std::move(parameter));
    }
    reader.expect_end();
    symbols_.add_external(std::move(external));
  }

  /// In a module EXT says only that the subprogram is elsewhere.
  void check_known(const std::string& name, const TokenReader& reader) const {
    if (!symbols_.find_external(name) && !symbols_.program.find_routine(name))
      reader.fail("EXT: no file that is loaded has the subprogram " + name);
  }

  const ModuleFile& list_;
  Symbols& symbols_;
  const std::vector<std::string>& pass_advance_run_;
  Scope scope_;
};

}  // namespace

void collect_types(const ModuleFile& list, Symbols& symbols) {
  for (const Statement& statement : list.statements) {
    const bool is_structure = declares_type(statement, "STRUC");
    if (!is_structure && !declares_type(statement, "ENUM")) continue;
    StatementReader reader(list.name, statement);
    symbols.attempt(list.is_partial, [&] {
      reader.take_if("GLOBAL");
      reader.take();
      is_structure ? add_type(read_structure(reader, symbols.program.types), list, reader, symbols)
                   : add_type(read_enumeration(reader), list, reader, symbols);
      reader.expect_end();
    });
  }
}

void compile_data(const ModuleFile& list, Symbols& symbols,
                  const std::vector<std::string>& pass_advance_run) {
  DataCompiler(list, symbols, pass_advance_run).compile();
}

}  // namespace truepose::sim::krl
