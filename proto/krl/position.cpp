#include "proto/krl/position.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/krl/hindrance_kinds.hpp"
#include "proto/text/kuka_names.hpp"

namespace truepose::krl {
namespace {

bool is_bits(const std::optional<Number>& number) {
  constexpr double kMost = 1 << 20;
  return number && number->value >= 0 && number->value < kMost && number->value == std::trunc(number->value);
}

}  // namespace

std::optional<Number> number_of(const Expression& expression) {
  const bool is_signed =
      expression.kind == ExpressionKind::Unary && (expression.name == "-" || expression.name == "+");
  const Expression& digits = is_signed ? expression.parts[0] : expression;
  const auto value = digits.kind == ExpressionKind::Constant ? digits.token.number() : std::nullopt;
  if (!value) return std::nullopt;
  return Number{static_cast<std::uint32_t>(expression.token.at), static_cast<std::uint32_t>(digits.end),
                is_signed && expression.name == "-" ? -*value : *value};
}

std::optional<int> index_of(const Expression& expression) {
  const auto number = number_of(expression);
  const bool is_index = number && number->value >= 0 && number->value <= 1e6;
  if (!is_index || number->value != std::trunc(number->value)) return std::nullopt;
  return static_cast<int>(number->value);
}

PositionForm form_of(const Expression& aggregate) {
  const bool of_axes = std::ranges::any_of(kAxisNames, [&](auto name) { return aggregate.find(name); });
  return of_axes ? PositionForm::Axes : PositionForm::Cartesian;
}

std::expected<Position, Message> position_of(const Expression& aggregate, std::size_t file) {
  Position position{
      .spot = {file, aggregate.token.at}, .form = form_of(aggregate), .values = {}, .status = {}, .turn = {}};
  const auto& names = position.form == PositionForm::Axes ? kAxisNames : kPoseNames;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Expression* value = aggregate.find(names[i]);
    if (!value) return std::unexpected(message<HindranceKind::Component>(names[i]));
    const auto number = number_of(*value);
    if (!number) return std::unexpected(message<HindranceKind::Number>(names[i]));
    position.values[i] = *number;
  }
  for (const auto& [name, number] : {std::pair{"S", &position.status}, std::pair{"T", &position.turn}}) {
    const Expression* value = aggregate.find(name);
    if (!value) continue;
    *number = number_of(*value);
    if (!is_bits(*number)) return std::unexpected(message<HindranceKind::Bits>(name));
  }
  return position;
}

}  // namespace truepose::krl
