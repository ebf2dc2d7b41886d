#include "tools/sim/krl/type.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace truepose::sim::krl {
namespace {

using SimpleKind = std::pair<std::string_view, Kind>;
constexpr std::array<SimpleKind, 4> kSimpleKinds = {
    {{"INT", Kind::Int}, {"REAL", Kind::Real}, {"BOOL", Kind::Bool}, {"CHAR", Kind::Char}}};

}  // namespace

std::string text_of(const Value& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text ? text->substr(0, text->find('\0')) : std::string{};
}

bool fill(std::string& array, std::string_view text) {
  const std::size_t size = array.size();
  if (text.size() > size) return false;
  array = text;
  array.resize(size, '\0');
  return true;
}

bool is_set(const Value& value) {
  if (const auto* parts = std::get_if<Parts>(&value)) return std::ranges::any_of(*parts, is_set);
  if (const auto* text = std::get_if<std::string>(&value))
    return std::ranges::any_of(*text, [](char c) { return c != '\0'; });
  return !std::holds_alternative<std::monostate>(value);
}

double number_of(const Value& value) {
  const auto* integer = std::get_if<std::int32_t>(&value);
  return integer ? *integer : std::get<double>(value);
}

std::optional<int> Structure::find(std::string_view field) const {
  const auto at = std::ranges::find(fields, field, &Field::name);
  return at == fields.end() ? std::nullopt : std::optional{static_cast<int>(at - fields.begin())};
}

bool Enumeration::has(std::string_view literal) const {
  return std::ranges::find(literals, literal) != literals.end();
}

std::optional<Type> Types::find(std::string_view name) const {
  const auto simple = std::ranges::find(kSimpleKinds, name, &SimpleKind::first);
  if (simple != kSimpleKinds.end()) return Type{simple->second};
  const auto structure = std::ranges::find(structures_, name, &Structure::name);
  if (structure != structures_.end())
    return Type{Kind::Structure, static_cast<int>(structure - structures_.begin())};
  const auto enumeration = std::ranges::find(enumerations_, name, &Enumeration::name);
  if (enumeration != enumerations_.end())
    return Type{Kind::Enumeration, static_cast<int>(enumeration - enumerations_.begin())};
  return std::nullopt;
}

std::string Types::name(const Type& type) const {
  std::string result;
  for (std::size_t i = 0; i < type.sizes.size(); ++i)
    result += (i > 0 ? "," : "[") + (type.sizes[i] > 0 ? std::to_string(type.sizes[i]) : "");
  if (type.is_array()) result += "]";
  if (type.kind == Kind::Structure) return structure(type).name + result;
  if (type.kind == Kind::Enumeration) return enumeration(type).name + result;
  const auto simple = std::ranges::find(kSimpleKinds, type.kind, &SimpleKind::second);
  return simple == kSimpleKinds.end() ? "nothing" : std::string(simple->first) + result;
}

Value Types::blank(const Type& type) const {
  if (type.is_text()) return std::string(static_cast<std::size_t>(type.sizes[0]), '\0');
  if (type.is_array()) return Parts(static_cast<std::size_t>(type.sizes[0]), blank(type.element()));
  if (type.kind != Kind::Structure) return {};
  Parts parts;
  for (const Field& field : structure(type).fields) parts.push_back(blank(field.type));
  return parts;
}

long Types::size(const Type& type, long limit) const {
  if (type.is_array()) {
    const long each = size(type.element(), limit);
    return each > 0 && type.sizes[0] > limit / each ? limit + 1 : each * type.sizes[0];
  }
  if (type.kind != Kind::Structure) return 1;
  long sum = 0;
  for (const Field& field : structure(type).fields) sum = std::min(sum + size(field.type, limit), limit + 1);
  return sum;
}

}  // namespace truepose::sim::krl
