#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/krl/expression.hpp"

namespace truepose::krl {

/// VARIABLE=VALUE.
struct Assignment {
  Expression variable, value;
};
Assignment read_assignment(TokenReader& reader);

/// Reads what stands behind WITH: assignments that commas separate. None without WITH.
std::vector<Assignment> read_settings(TokenReader& reader);

/// PTP, LIN_REL, SCIRC ... up to what stands behind its targets and WITH: approximations.
struct Motion {
  std::string word;  ///< PTP, LIN_REL, SCIRC ..., in capitals
  std::vector<Expression>
      targets;        ///< two of an arc, its auxiliary point first; fewer where they are missing
  std::string frame;  ///< of a relative one: BASE or TOOL, where it says so
  std::optional<Expression> angle;   ///< of an arc: CA
  std::vector<Assignment> settings;  ///< of one that begins with S: WITH

  bool is_spline() const { return word.starts_with('S'); }
  bool is_relative() const { return word.ends_with("_REL"); }
  std::size_t target_count() const { return word.contains("CIRC") ? 2 : 1; }
};
bool is_motion(const Token& word);
Motion read_motion(TokenReader& reader);

/// DECL GLOBAL CONST E6POS P={X 1,Y 2},Q[3].
struct Declaration {
  struct Name {
    Token token;
    std::vector<int> sizes;           ///< of an array; 0: as long as what is passed
    std::optional<Expression> value;  ///< what it begins with
  };
  bool is_global = false, is_constant = false;
  Token type;
  std::vector<Name> names;
};
/// The type of what may be a declaration: DECL, GLOBAL, CONST or nothing stands before it, a name behind it.
/// Null where none is.
const Token* declared_type(Tokens statement);
/// @param declaration  is filled as far as it can be read
void read_declaration(TokenReader& reader, Declaration& declaration);

/// Reads [3,4], [] or nothing.
std::vector<int> read_sizes(TokenReader& reader);

/// Whether a statement is the head of a subprogram: [GLOBAL] DEF or DEFFCT.
bool begins_routine(Tokens statement);

}  // namespace truepose::krl
