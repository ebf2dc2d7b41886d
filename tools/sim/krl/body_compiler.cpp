#include "tools/sim/krl/body_compiler.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace truepose::sim::krl {
namespace {

/// Loops and branches in one another, so that no text uses up the stack.
constexpr std::size_t kDeepestBlock = 60;

/// The head of a subprogram and its declarations.
class RoutineScanner {
 public:
  RoutineScanner(const ModuleFile& file, Symbols& symbols)
      : file_{file}, statements_{file.statements}, symbols_{symbols} {}

  std::vector<Body> scan() {
    std::vector<Body> bodies;
    while (at_ < statements_.size()) {
      const std::size_t first = at_;
      const auto read = [&] { bodies.push_back(routine()); };
      if (symbols_.attempt(file_.is_partial, read, {name_of(statements_[first])})) continue;
      for (at_ = first + 1; at_ < statements_.size() && !begins_routine(statements_[at_]);) ++at_;
    }
    return bodies;
  }

 private:
  /// What stands before the parameters.
  static std::string name_of(const Statement& head) {
    const auto bracket = std::ranges::find_if(head, [](const Token& token) { return token.is("("); });
    return bracket == head.begin() ? std::string{} : (bracket - 1)->word();
  }

  Body routine() {
    StatementReader reader(file_.name, statements_[at_]);
    Routine routine{.file = file_.file, .line = statements_[at_][0].line, .module = file_.module};
    routine.is_global = reader.take_if("GLOBAL");
    const bool is_function = reader.take_if("DEFFCT");
    if (!is_function && !reader.take_if("DEF"))
      reader.fail("DEF or DEFFCT is expected before " + reader.peek().word());
    if (is_function) {
      routine.result = type_of(reader.take(), reader, symbols_.program.types);
      routine.result = sized(routine.result, read_sizes(reader), reader, symbols_.program.types);
    }
    routine.name = reader.take_name("the name of the subprogram");
    symbols_.check_new_name(routine.name, reader);
    // The first subprogram of a module carries its name and is known everywhere.
    routine.is_global = routine.is_global || routine.name == symbols_.module_name(file_.module);
    read_parameters(reader, routine);
    reader.expect_end();
    ++at_;
    Body body{.routine = symbols_.program.routines.size(),
              .file = &file_,
              .is_submit = in_capitals(file_.name).ends_with(".SUB")};
    read_declarations(routine, body);
    take_statements(routine, is_function ? "ENDFCT" : "END", body);
    symbols_.add_routine(std::move(routine));
    return body;
  }

  void read_parameters(TokenReader& reader, Routine& routine) {
    reader.expect("(");
    while (!reader.take_if(")")) {
      if (!routine.parameters.empty()) reader.expect(",");
      Parameter parameter{.name = reader.take_name("a parameter")};
      symbols_.check_new_name(parameter.name, reader);
      if (std::ranges::count(routine.parameters, parameter.name, &Parameter::name) > 0)
        reader.fail("the parameter " + parameter.name + " is named twice");
      if (reader.take_if("[")) {
        while (reader.take_if(",")) {
        }
        reader.expect("]");
      }
      parameter.direction = read_direction(reader);
      routine.parameters.push_back(std::move(parameter));
    }
  }

  void read_declarations(Routine& routine, Body& body) {
    for (const Parameter& parameter : routine.parameters) body.locals.push_back({parameter.name, {}});
    for (; at_ < statements_.size(); ++at_) {
      StatementReader reader(file_.name, statements_[at_]);
      if (!begins_declaration(reader, symbols_.program.types)) break;
      symbols_.attempt(file_.is_partial, [&] { read_declaration(reader, body); });
    }
    for (std::size_t i = 0; i < routine.parameters.size(); ++i) {
      routine.parameters[i].type = body.locals[i].type;
      if (body.locals[i].type.kind == Kind::None)
        throw Fault{file_.name, routine.line,
                    "the type of the parameter " + body.locals[i].name + " is not declared"};
    }
  }

  void read_declaration(TokenReader& reader, Body& body) {
    Declaration declaration;
    truepose::krl::read_declaration(reader, declaration);
    reader.expect_end();
    if (declaration.is_global || declaration.is_constant)
      reader.fail("local data is neither GLOBAL nor CONST");
    const Type type = type_of(declaration.type, reader, symbols_.program.types);
    for (const Declaration::Name& name : declaration.names) {
      symbols_.check_new_name(name.token.word(), reader);
      declare({name.token.word(), sized(type, name.sizes, reader, symbols_.program.types)}, reader, body);
      if (name.value)
        reader.fail("a declaration in a program has no initial value; it belongs into the data list");
    }
  }

  static void declare(Field local, const TokenReader& reader, Body& body) {
    const auto known = std::ranges::find(body.locals, local.name, &Field::name);
    if (known == body.locals.end()) {
      if (std::ranges::count(local.type.sizes, 0) > 0) reader.fail(local.name + " needs a size");
      body.locals.push_back(std::move(local));
    } else if (known->type.kind == Kind::None) {
      known->type = local.type;
    } else {
      reader.fail(local.name + " is declared twice");
    }
  }

  void take_statements(const Routine& routine, std::string_view end, Body& body) {
    const std::size_t first = at_;
    for (; at_ < statements_.size(); ++at_) {
      const Statement& statement = statements_[at_];
      if (statement[0].is(end)) break;
      if (statement[0].is_any_of({"DEF", "DEFFCT", "END", "ENDFCT"}))
        throw Fault{file_.name, statement[0].line, std::string(end) + " of " + routine.name + " is missing"};
    }
    if (at_ == statements_.size())
      throw Fault{file_.name, routine.line, std::string(end) + " of " + routine.name + " is missing"};
    body.statements = statements_.subspan(first, at_ - first);
    body.end = statements_[at_];
    StatementReader reader(file_.name, body.end);
    reader.take();
    reader.expect_end();
    ++at_;
  }

  const ModuleFile& file_;
  std::span<const Statement> statements_;
  Symbols& symbols_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<Body> scan_routines(const ModuleFile& file, Symbols& symbols) {
  return RoutineScanner(file, symbols).scan();
}

BodyCompiler::BodyCompiler(const Body& body, Symbols& symbols)
    : body_{body},
      symbols_{symbols},
      scope_{.symbols = symbols,
             .module = symbols.program.routines[body.routine].module,
             .file = symbols.program.routines[body.routine].file,
             .locals = body.locals,
             .is_submit = body.is_submit},
      expressions_{scope_} {}

void BodyCompiler::compile() {
  symbols_.program.routines[body_.routine].entry = scope_.here();
  compile_statements();
  scope_.line = body_.end[0].line;
  scope_.emit(Op::Statement);
  Routine& routine = symbols_.program.routines[body_.routine];
  scope_.emit(routine.result.kind == Kind::None ? Op::Return : Op::NoResult);
  routine.local_names = scope_.locals;
  for (std::size_t i = 0; i < scope_.locals.size(); ++i) {
    const bool is_parameter = i < routine.parameters.size();
    routine.locals.push_back(is_parameter ? Value{} : scope_.types().blank(scope_.locals[i].type));
  }
}

void BodyCompiler::compile_statements() {
  const auto part = [&] {
    while (!at_end()) statement();
    land_gotos();
  };
  // Of a partial file, a subprogram whose loops and branches do not close stops the program where it is
  // called.
  attempt(part, [] { return true; });
}

bool BodyCompiler::next_begins_with(std::string_view word) const {
  return !at_end() && body_.statements[at_][0].is(word);
}

std::string BodyCompiler::block(std::initializer_list<std::string_view> ends, const Statement& opened) {
  if (blocks_.size() == kDeepestBlock) scope_.fail("loops and branches are nested too deeply");
  blocks_.push_back(++block_count_);
  while (true) {
    if (at_end())
      throw Fault{body_.file->name, opened[0].line, std::string(*(ends.end() - 1)) + " is missing"};
    for (const std::string_view end : ends) {
      if (!next_begins_with(end)) continue;
      blocks_.pop_back();
      scope_.line = body_.statements[at_][0].line;
      return std::string(end);
    }
    statement();
  }
}

void BodyCompiler::close(std::string_view word) {
  StatementReader reader(body_.file->name, body_.statements[at_++]);
  reader.expect(word);
  reader.expect_end();
}

void BodyCompiler::statement() {
  const Statement& statement = body_.statements[at_++];
  scope_.line = statement[0].line;
  scope_.is_continued = std::exchange(continued_, false);
  scope_.emit(Op::Statement);
  StatementReader reader(body_.file->name, statement);
  attempt([&] { dispatch(reader); });
}

void BodyCompiler::attempt(const std::function<void()>& part) {
  attempt(part, [this, statement = at_, loops = exits_.size(), blocks = blocks_.size()] {
    return at_ == statement && exits_.size() == loops && blocks_.size() == blocks;
  });
}

void BodyCompiler::attempt(const std::function<void()>& part, const std::function<bool()>& leaves_it) {
  if (!body_.file->is_partial) return part();
  const std::size_t before = scope_.here();
  const std::vector<Field> locals = scope_.locals;
  try {
    part();
  } catch (const Fault& fault) {
    if (!leaves_it()) throw;
    scope_.locals = locals;
    scope_.aside = {};
    scope_.refuse(before, fault);
  }
}

void BodyCompiler::dispatch(TokenReader& reader) {
  const Token& first = reader.peek();
  if (first.kind != TokenKind::Name) reader.fail("a statement cannot begin with " + first.word());
  // SPL stands in spline blocks alone.
  if (motions().contains(first.word()) && !first.is("SPL")) return compile_motion(reader);
  if (const auto compile = statements().find(first.word()); compile != statements().end())
    return (this->*compile->second)(reader);
  if (reader.peek(1).is_any_of({"=", "[", "."})) return compile_assignment(reader);
  if (reader.peek(1).is("(")) {
    const Expression call = read_call(reader);
    reader.expect_end();
    return expressions_.call_statement(call);
  }
  if (reader.peek(1).is(":")) return compile_label(reader);
  if (begins_declaration(reader, scope_.types()))
    reader.fail("declarations stand before the first statement");
  reader.fail("the statement " + first.word() + " is not known here");
}

const std::map<std::string_view, BodyCompiler::Compile>& BodyCompiler::statements() {
  static const std::map<std::string_view, Compile> kStatements = {
      {"IF", &BodyCompiler::compile_if},
      {"SWITCH", &BodyCompiler::compile_switch},
      {"FOR", &BodyCompiler::compile_for},
      {"WHILE", &BodyCompiler::compile_while},
      {"REPEAT", &BodyCompiler::compile_repeat},
      {"LOOP", &BodyCompiler::compile_loop},
      {"EXIT", &BodyCompiler::compile_exit},
      {"GOTO", &BodyCompiler::compile_goto},
      {"RETURN", &BodyCompiler::compile_return},
      {"HALT", &BodyCompiler::compile_plain},
      {"CONTINUE", &BodyCompiler::compile_continue},
      {"SPLINE", &BodyCompiler::compile_spline},
      {"PTP_SPLINE", &BodyCompiler::compile_spline},
      {"TRIGGER", &BodyCompiler::compile_trigger},
      {"PULSE", &BodyCompiler::compile_pulse},
      {"ON_ERROR_PROCEED", &BodyCompiler::compile_plain},
      {"WAIT", &BodyCompiler::compile_wait},
      {"INTERRUPT", &BodyCompiler::compile_interrupt},
      {"GLOBAL", &BodyCompiler::compile_interrupt},
      {"BRAKE", &BodyCompiler::compile_brake},
      {"RESUME", &BodyCompiler::compile_plain}};
  return kStatements;
}

}  // namespace truepose::sim::krl
