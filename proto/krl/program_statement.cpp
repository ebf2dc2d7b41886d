#include "proto/krl/program_statement.hpp"

#include <algorithm>
#include <ranges>
#include <string>
#include <utility>

namespace truepose::krl {
namespace {

/// More than any of KUKA's structures has; what is longer is no aggregate.
constexpr std::size_t kMostComponents = 256;

/// What a reader makes of tokens, or nothing where they are something else.
template <typename Read>
auto read_if(Tokens tokens, Read read) -> std::optional<decltype(read(std::declval<TokenReader&>()))> {
  if (tokens.empty()) return std::nullopt;
  try {
    TokenReader reader(tokens);
    return read(reader);
  } catch (const Fault&) {
    return std::nullopt;
  }
}

/// Throws Fault where the tokens of a statement are part of none of KRL.
class Check {
 public:
  void operator()(Tokens tokens) {
    open_.clear();
    components_.clear();
    for (std::size_t i = 0; i < tokens.size(); ++i) {
      const Token& token = tokens[i];
      const bool is_number = token.kind == TokenKind::Integer || token.kind == TokenKind::Real;
      if (is_number && !token.number())
        throw Fault{token.at, "a number out of range; give one that KRL can hold"};
      const bool may_be_component =
          token.kind == TokenKind::Name && !open_.empty() && open_.back().bracket->is("{");
      if (may_be_component && tokens[i - 1].is_any_of({"{", ","})) add_component(token);
      if (token.opens()) open_.push_back({&token, components_.size()});
      if (token.closes() && !open_.empty()) close();
    }
    const auto brace = std::ranges::find_if(open_, [](const Open& open) { return open.bracket->is("{"); });
    if (brace != open_.end())
      throw Fault{brace->bracket->at, "a brace that is not closed; close it in the same statement"};
  }

 private:
  /// A bracket, and where the components of the aggregate that it is begin.
  struct Open {
    const Token* bracket;
    std::size_t first;
  };

  void add_component(const Token& name) {
    const auto its = components_ | std::views::drop(open_.back().first);
    if (std::ranges::any_of(its, [&](const Token* other) { return other->is_same_name(name); }))
      throw Fault{name.at, "component " + std::string(name.text) + " is given twice; remove one"};
    components_.push_back(&name);
    if (std::ranges::size(its) > kMostComponents)
      throw Fault{name.at, "too many components; give at most 256"};
  }

  void close() {
    components_.resize(open_.back().first);
    open_.pop_back();
  }

  std::vector<Open> open_;
  std::vector<const Token*> components_;  // of all that is open
};

Tokens action_of(Tokens statement) {
  const bool is_global = statement.size() > 1 && statement[0].is("GLOBAL");
  if (!statement[is_global ? 1 : 0].is_any_of({"TRIGGER", "INTERRUPT"})) return statement;
  const auto found = std::ranges::find_if(statement, [](const Token& token) { return token.is("DO"); });
  return found == statement.end() ? Tokens{} : Tokens(found + 1, statement.end());
}

Assignment read_change(TokenReader& reader) {
  Assignment change{.variable = read_variable(reader), .value = {}};
  reader.expect("=");
  change.value = {.kind = ExpressionKind::Omitted, .token = change.variable.token};
  const auto read_whole = [](TokenReader& rest) {
    Expression whole = read_expression(rest);
    rest.expect_end();
    return whole;
  };
  if (auto value = read_if(reader.rest(), read_whole)) change.value = *std::move(value);
  return change;
}

/// What is read from each name before a bracket of some kind.
template <typename Read>
std::vector<Expression> parts(Tokens action, std::string_view bracket, Read read) {
  std::vector<Expression> parts;
  for (std::size_t i = 0; i + 1 < action.size(); ++i) {
    if (action[i].kind != TokenKind::Name || !action[i + 1].is(bracket)) continue;
    if (auto part = read_if(action.subspan(i), read)) parts.push_back(*std::move(part));
  }
  return parts;
}

/// Null where it declares nothing that says where the arm goes.
const Token* declared_place(Tokens statement) {
  const Token* type = declared_type(statement);
  return type && type->is_any_of({"E6POS", "POS", "E6AXIS", "AXIS", "FRAME", "FDAT"}) ? type : nullptr;
}

bool may_assign(Tokens action) { return action.size() > 1 && action[1].is_any_of({"=", "[", "."}); }

/// Whether it has a call or an element.
bool has_parts(Tokens action) {
  const auto is_part = [](const Token& name, const Token& bracket) {
    return name.kind == TokenKind::Name && bracket.is_any_of({"(", "["});
  };
  return std::ranges::adjacent_find(action, is_part) != action.end();
}

bool is_use(const ProgramStatement& statement) {
  return statement.is_head || may_assign(statement.action) || has_parts(statement.action) ||
         statement.is_label() || statement.tokens[0].is("GOTO");
}

void sort_in(const ProgramStatement& statement, TextStatements& statements) {
  const bool uses = is_use(statement), declares = declared_place(statement.tokens) != nullptr;
  const bool only_declares = !uses && (declares || statement.tokens[0].is("DECL"));
  if (declares) statements.declarations.add(statement);
  if (uses) statements.uses.add(statement);
  if (!only_declares) statements.steps.add(statement);
}

}  // namespace

ProgramStatement::ProgramStatement(Tokens tokens_in, std::size_t routine_in)
    : tokens{tokens_in},
      is_head{begins_routine(tokens_in)},
      routine{routine_in},
      action{action_of(tokens_in)} {}

bool ProgramStatement::moves() const { return is_motion(tokens[0]) && !assignment(); }

std::optional<Declaration> ProgramStatement::declaration() const {
  if (!declared_place(tokens)) return std::nullopt;
  Declaration declaration;
  read_if(tokens, [&](TokenReader& reader) {
    read_declaration(reader, declaration);
    return true;
  });
  return declaration;
}

std::optional<Motion> ProgramStatement::motion() const { return read_if(tokens, read_motion); }

std::optional<Assignment> ProgramStatement::assignment() const {
  return may_assign(action) ? read_if(action, read_change) : std::nullopt;
}

std::vector<Assignment> ProgramStatement::settings() const {
  return read_if(tokens.subspan(1), read_settings).value_or(std::vector<Assignment>{});
}

std::vector<Expression> ProgramStatement::calls() const { return parts(action, "(", read_call); }

std::vector<Expression> ProgramStatement::elements() const { return parts(action, "[", read_variable); }

std::optional<Expression> ProgramStatement::bas() const {
  const bool is_call = action.size() > 1 && action[0].is("BAS") && action[1].is("(");
  return is_call ? read_if(action, read_call) : std::nullopt;
}

std::expected<TextStatements, Fault> read_statements(std::string_view text) {
  TextStatements statements{Statements(text), Statements(text), Statements(text)};
  Cutter cutter(text);
  Check check;
  std::size_t routine = 0;
  try {
    for (Tokens tokens = cutter.next(); !tokens.empty(); tokens = cutter.next()) {
      check(tokens);
      if (begins_routine(tokens)) ++routine;
      sort_in({tokens, routine}, statements);
    }
  } catch (const Fault& fault) {
    return std::unexpected(fault);
  }
  return statements;
}

}  // namespace truepose::krl
