#include "proto/krl/position.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

#include "proto/krl/hindrance_kinds.hpp"
#include "proto/text/kuka_names.hpp"

namespace truepose::krl {
namespace {

/// More than any of KUKA's structures has; what is longer is no aggregate.
constexpr std::size_t kMostComponents = 256;

/// Where the value that starts at `from` ends: at a comma or at the brace that closes the aggregate.
std::size_t end_of_value(Tokens tokens, std::size_t from) {
  int depth = 0;
  for (std::size_t i = from; i < tokens.size(); ++i) {
    if (depth == 0 && (tokens[i].is(',') || tokens[i].is('}'))) return i;
    if (tokens[i].opens()) ++depth;
    if (tokens[i].closes()) --depth;
  }
  return tokens.size();
}

std::optional<double> decimal(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// 'B0101' and 'HFF'; blanks within are allowed.
std::optional<double> based(std::string_view quoted) {
  std::string digits;
  std::ranges::copy_if(quoted.substr(1, quoted.size() - 2), std::back_inserter(digits),
                       [](char c) { return c != ' '; });
  const std::string prefix = in_capitals(digits.substr(0, 1));
  if (prefix != "B" && prefix != "H") return std::nullopt;
  unsigned value = 0;
  const char* last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data() + 1, last, value, prefix == "B" ? 2 : 16);
  if (error != std::errc{} || end != last) return std::nullopt;
  return value;
}

std::expected<Field, Fault> read_field(Tokens tokens) {
  Field field{.name = tokens[0].text, .number = {}, .word = {}};
  const Tokens value = tokens.subspan(1);
  const auto number = read_number(value);
  if (!number) return std::unexpected(number.error());
  field.number = *number;
  if (value.size() == 1) field.word = value[0].text;
  return field;
}

bool is_bits(const std::optional<Number>& number) {
  constexpr double kMost = 1 << 20;
  return number && number->value >= 0 && number->value < kMost && number->value == std::trunc(number->value);
}

}  // namespace

const Field* Aggregate::find(std::string_view name) const {
  const auto found = std::ranges::find_if(fields, [&](const Field& field) {
    return Token{TokenKind::Name, field.name, 0}.is(name);
  });
  return found == fields.end() ? nullptr : &*found;
}

std::expected<std::optional<Number>, Fault> read_number(Tokens tokens) {
  std::optional<Number> none;
  if (tokens.empty() || tokens.size() > 2) return none;
  const bool is_signed = tokens.size() == 2;
  if (is_signed && !tokens[0].is('+') && !tokens[0].is('-')) return none;
  const Token& digits = tokens.back();
  std::optional<double> value;
  if (digits.kind == TokenKind::Number) {
    value = decimal(digits.text);
    if (!value) return std::unexpected(Fault{digits.at, "a number out of range; give one that KRL can hold"});
  } else if (digits.kind == TokenKind::Literal) {
    value = based(digits.text);
  }
  if (!value) return none;
  return Number{tokens[0].at, digits.end(), is_signed && tokens[0].is('-') ? -*value : *value};
}

std::expected<Aggregate, Fault> read_aggregate(Tokens tokens, std::size_t& next) {
  const auto not_closed = [&] {
    return std::unexpected(
        Fault{tokens[next].at, "a brace that is not closed; close it in the same statement"});
  };
  Aggregate aggregate{.at = tokens[next].at, .fields = {}};
  std::size_t i = next + 1;
  const bool names_its_type =
      i + 1 < tokens.size() && tokens[i].kind == TokenKind::Name && tokens[i + 1].is(':');
  if (names_its_type) i += 2;
  while (true) {
    const std::size_t end = end_of_value(tokens, i);
    if (end == tokens.size()) return not_closed();
    if (aggregate.fields.size() == kMostComponents)
      return std::unexpected(Fault{tokens[i].at, "too many components; give at most 256"});
    if (end > i && tokens[i].kind == TokenKind::Name) {
      if (aggregate.find(in_capitals(tokens[i].text)))
        return std::unexpected(
            Fault{tokens[i].at, "component " + std::string(tokens[i].text) + " is given twice; remove one"});
      const auto field = read_field(tokens.subspan(i, end - i));
      if (!field) return std::unexpected(field.error());
      aggregate.fields.push_back(*field);
    }
    i = end + 1;
    aggregate.closed_at = tokens[end].at;
    if (tokens[end].is('}')) break;
  }
  next = i;
  return aggregate;
}

std::expected<Position, Message> position_of(const Aggregate& aggregate, std::size_t file) {
  const bool of_axes = std::ranges::any_of(kAxisNames, [&](auto name) { return aggregate.find(name); });
  Position position{.spot = {file, aggregate.at},
                    .form = of_axes ? PositionForm::Axes : PositionForm::Cartesian,
                    .values = {},
                    .status = {},
                    .turn = {}};
  const auto& names = of_axes ? kAxisNames : kPoseNames;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Field* field = aggregate.find(names[i]);
    if (!field) return std::unexpected(message<HindranceKind::Component>(names[i]));
    if (!field->number) return std::unexpected(message<HindranceKind::Number>(names[i]));
    position.values[i] = *field->number;
  }
  for (const auto& [name, number] : {std::pair{"S", &position.status}, std::pair{"T", &position.turn}}) {
    const Field* field = aggregate.find(name);
    if (!field) continue;
    if (!is_bits(field->number)) return std::unexpected(message<HindranceKind::Bits>(name));
    *number = *field->number;
  }
  return position;
}

}  // namespace truepose::krl
