#pragma once

#include <array>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "proto/krl/lexer.hpp"
#include "proto/krl/spot.hpp"
#include "proto/text/message.hpp"

namespace truepose::krl {

/// A number in a text: its sign and digits are the bytes [begin, end).
struct Number {
  std::size_t begin = 0, end = 0;
  double value = 0;
};

/// One `NAME value` of an aggregate.
struct Field {
  std::string_view name;
  std::optional<Number> number;  ///< where the value is one
  std::string_view word;         ///< where the value is a single token
};

/// `{X 1.0,Y 2.0}`, or `{FRAME: X 1.0,Y 2.0}`.
struct Aggregate {
  std::size_t at = 0;
  std::size_t closed_at = 0;  ///< byte offset of its closing brace
  std::vector<Field> fields;

  /// @param name  in capitals
  const Field* find(std::string_view name) const;
};

/// Reads the aggregate whose brace is tokens[next], and leaves `next` behind it. Components that are
/// aggregates or arrays themselves have neither number nor word.
/// Errors: a brace that is not closed, a component given twice, more than 256 of them, a number out of range.
std::expected<Aggregate, Fault> read_aggregate(Tokens tokens, std::size_t& next);

/// The number that is all of `tokens`: with or without a sign, binary ('B01') or hexadecimal ('HFF'). No
/// value where they are something else. Errors: a number out of range.
std::expected<std::optional<Number>, Fault> read_number(Tokens tokens);

enum class PositionForm {
  Cartesian,  ///< X, Y, Z (mm), A, B, C (deg): POS, E6POS, FRAME
  Axes,       ///< A1..A6 (deg): AXIS, E6AXIS
};

/// A position of the arm as it is written. External axes are no part of it.
struct Position {
  Spot spot;  ///< of its brace
  PositionForm form = PositionForm::Cartesian;
  std::array<Number, 6> values;  ///< X, Y, Z, A, B, C or A1..A6
  std::optional<Number> status, turn;
};

/// @return the position, or why the aggregate is no whole one
std::expected<Position, Message> position_of(const Aggregate& aggregate, std::size_t file);

}  // namespace truepose::krl
