#pragma once

#include "proto/krl/statement.hpp"

namespace truepose::krl {

/// A statement of a program. What it says of where the arm goes is read where it is asked for. What cannot be
/// read of it is left out, since programs use what is not known here.
struct ProgramStatement {
  ProgramStatement(Tokens tokens_in, std::size_t routine_in);

  Tokens tokens;
  bool is_head = false;     ///< of a routine: DEF or DEFFCT, which looks like a call of itself
  std::size_t routine = 0;  ///< number of its head in the text, the first = 1; 0: before any
  /// Of the tokens: what TRIGGER ... DO or INTERRUPT ... DO carries out later, else all.
  Tokens action;

  std::size_t at() const { return tokens[0].at; }
  bool is_later() const { return action.data() != tokens.data(); }
  bool is_label() const { return tokens.size() > 1 && tokens[1].is(":"); }
  /// Whether it is a motion, and no assignment to a variable that is called like one.
  bool moves() const;

  /// Of POS, E6POS, AXIS, E6AXIS, FRAME and FDAT: what is declared of them says where the arm goes.
  std::optional<Declaration> declaration() const;
  std::optional<Motion> motion() const;
  std::optional<Assignment> assignment() const;  ///< of the action; a value that cannot be read is Omitted
  std::vector<Assignment> settings() const;      ///< of SPLINE: WITH
  std::vector<Expression> calls() const;         ///< all of the action
  std::vector<Expression> elements() const;      ///< NAME[index], all of the action
  std::optional<Expression> bas() const;         ///< the call of BAS() that the action is
};

/// Some statements of a text in their order. It keeps their places and cuts them again each time, since their
/// tokens take far more memory than the text.
class Statements {
 public:
  explicit Statements(std::string_view text = {}) : text_{text} {}
  void add(const ProgramStatement& statement) { places_.push_back({statement.at(), statement.routine}); }
  std::size_t size() const { return places_.size(); }
  /// @param read  takes a ProgramStatement, which lasts until it returns
  template <typename Read>
  void each(Read read) const {
    Cutter cutter(text_);
    for (const Place& place : places_) {
      cutter.go_to(place.at);
      read(ProgramStatement(cutter.next(), place.routine));
    }
  }

 private:
  struct Place {
    std::size_t at = 0, routine = 0;
  };

  std::string_view text_;
  std::vector<Place> places_;
};

/// The statements of a text by what is looked for in them.
struct TextStatements {
  Statements declarations;  ///< that declare where the arm goes
  Statements uses;          ///< that assign, call, name elements, or are the ends of routines and jumps
  Statements steps;         ///< all but plain declarations
};

/// @param text  outlives the statements
/// Errors: a text or brace that is not closed, an aggregate with a component twice or more than 256 of them,
/// a number in one that is out of range.
std::expected<TextStatements, Fault> read_statements(std::string_view text);

}  // namespace truepose::krl
