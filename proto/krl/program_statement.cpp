#include "proto/krl/program_statement.hpp"

#include <algorithm>
#include <set>
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

/// A bracket that is open, and the components of the aggregate that it is, in capitals.
struct Open {
  const Token& bracket;
  std::set<std::string> components = {};
};

void add_component(Open& aggregate, const Token& name) {
  if (!aggregate.components.insert(name.word()).second)
    throw Fault{name.at, "component " + std::string(name.text) + " is given twice; remove one"};
  if (aggregate.components.size() > kMostComponents)
    throw Fault{name.at, "too many components; give at most 256"};
}

/// Throws Fault where the tokens are part of no statement of KRL.
void check(Tokens tokens) {
  std::vector<Open> open;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const Token& token = tokens[i];
    const bool is_number = token.kind == TokenKind::Integer || token.kind == TokenKind::Real;
    if (is_number && !token.number())
      throw Fault{token.at, "a number out of range; give one that KRL can hold"};
    const bool may_be_component =
        token.kind == TokenKind::Name && !open.empty() && open.back().bracket.is("{");
    if (may_be_component && tokens[i - 1].is_any_of({"{", ","})) add_component(open.back(), token);
    if (token.opens()) open.push_back({token});
    if (token.closes() && !open.empty()) open.pop_back();
  }
  const auto brace = std::ranges::find_if(open, [](const Open& other) { return other.bracket.is("{"); });
  if (brace != open.end())
    throw Fault{brace->bracket.at, "a brace that is not closed; close it in the same statement"};
}

Tokens action_of(Tokens statement) {
  const bool is_global = statement.size() > 1 && statement[0].is("GLOBAL");
  if (!statement[is_global ? 1 : 0].is_any_of({"TRIGGER", "INTERRUPT"})) return statement;
  const auto found = std::ranges::find_if(statement, [](const Token& token) { return token.is("DO"); });
  return found == statement.end() ? Tokens{} : Tokens(found + 1, statement.end());
}

/// Of POS, E6POS, AXIS, E6AXIS, FRAME and FDAT: what is declared of them says where the arm goes.
std::optional<Declaration> declaration_in(Tokens statement) {
  const Token* type = declared_type(statement);
  if (!type || !type->is_any_of({"E6POS", "POS", "E6AXIS", "AXIS", "FRAME", "FDAT"})) return std::nullopt;
  Declaration declaration;
  read_if(statement, [&](TokenReader& reader) {
    read_declaration(reader, declaration);
    return true;
  });
  return declaration;
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

void read_parts(ProgramStatement& statement) {
  const Tokens action = statement.action;
  for (std::size_t i = 0; i + 1 < action.size(); ++i) {
    if (action[i].kind != TokenKind::Name) continue;
    if (action[i + 1].is("(")) {
      if (auto call = read_if(action.subspan(i), read_call)) statement.calls.push_back(*std::move(call));
    } else if (action[i + 1].is("[")) {
      if (auto element = read_if(action.subspan(i), read_variable))
        statement.elements.push_back(*std::move(element));
    }
  }
}

void read_forms(ProgramStatement& statement) {
  const Tokens tokens = statement.tokens;
  check(tokens);
  statement.action = action_of(tokens);
  statement.declaration = declaration_in(tokens);
  if (statement.action.size() > 1 && statement.action[1].is_any_of({"=", "[", "."}))
    statement.assignment = read_if(statement.action, read_change);
  // A variable may be called like a motion.
  if (!statement.assignment && is_motion(tokens[0])) statement.motion = read_if(tokens, read_motion);
  if (tokens[0].is_any_of({"SPLINE", "PTP_SPLINE"}))
    statement.settings = read_if(tokens.subspan(1), read_settings).value_or(std::vector<Assignment>{});
  read_parts(statement);
}

}  // namespace

const Expression* ProgramStatement::bas() const {
  return !calls.empty() && calls[0].name == "BAS" && calls[0].token.at == action[0].at ? &calls[0] : nullptr;
}

std::expected<std::vector<ProgramStatement>, Fault> read_statements(std::string_view text) {
  auto cut = cut_into_statements(text);
  if (!cut) return std::unexpected(cut.error());
  std::vector<ProgramStatement> statements(cut->size());
  std::size_t routine = 0;
  try {
    for (std::size_t i = 0; i < cut->size(); ++i) {
      ProgramStatement& statement = statements[i];
      statement.tokens = std::move((*cut)[i]);
      statement.is_head = begins_routine(statement.tokens);
      statement.routine = routine += statement.is_head ? 1 : 0;
      read_forms(statement);
    }
  } catch (const Fault& fault) {
    return std::unexpected(fault);
  }
  return statements;
}

}  // namespace truepose::krl
