#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>

#include "proto/krl/expression.hpp"
#include "proto/krl/spot.hpp"
#include "proto/text/message.hpp"

namespace truepose::krl {

/// A number in a text: its sign and digits are the bytes [begin, end). A program has millions of them, and no
/// text is as long as 4 GB.
struct Number {
  std::uint32_t begin = 0, end = 0;
  double value = 0;
};

/// A number with or without a sign, which may be binary ('B01') or hexadecimal ('HFF'); none of all else.
std::optional<Number> number_of(const Expression& expression);

/// The same as a whole number of a table, 0 to 1e6.
std::optional<int> index_of(const Expression& expression);

enum class PositionForm {
  Cartesian,  ///< X, Y, Z (mm), A, B, C (deg): POS, E6POS, FRAME
  Axes,       ///< A1..A6 (deg): AXIS, E6AXIS
};
/// What an aggregate writes: it is of axes where it names one.
PositionForm form_of(const Expression& aggregate);

/// A position of the arm as it is written. External axes are no part of it.
struct Position {
  Spot spot;  ///< of its brace
  PositionForm form = PositionForm::Cartesian;
  std::array<Number, 6> values;  ///< X, Y, Z, A, B, C or A1..A6
  std::optional<Number> status, turn;
};

/// @return the position, or why the aggregate is no whole one
std::expected<Position, Message> position_of(const Expression& aggregate, std::size_t file);

}  // namespace truepose::krl
