#include "proto/record/json_io.hpp"

#include <algorithm>
#include <cmath>

#include "proto/control/json_text.hpp"
#include "proto/text/renamed.hpp"

namespace truepose::record {
namespace {

namespace json = boost::json;

std::string plain(double number) { return control::json_text(json::value(number)); }

/// "of 0 or more", "1..100"; nothing where there is no bound.
std::string within(const std::string& min, const std::string& max, bool has_min, bool has_max) {
  if (has_min && has_max) return " " + min + ".." + max;
  return has_min ? " of " + min + " or more" : "";
}

}  // namespace

bool is_finite(const json::value& value) {
  if (const auto* object = value.if_object())
    return std::ranges::all_of(*object, [](const auto& member) { return is_finite(member.value()); });
  if (const auto* array = value.if_array()) return std::ranges::all_of(*array, is_finite);
  return !value.is_double() || std::isfinite(value.get_double());
}

JsonText::Value JsonText::record(std::vector<std::pair<std::string, Value>> members) {
  json::object object;
  for (auto& [key, value] : members) object[key] = std::move(value);
  return object;
}

void JsonPlace::fail(const std::string& what) const {
  throw RecordError((path_.empty() ? "" : path_ + ": ") + what);
}

void JsonPlace::fail_expected(const std::string& what) const {
  fail("expected " + what + ", found " + control::json_excerpt(*value_));
}

double JsonPlace::number(Range range) const {
  const double number = value_->is_number() ? value_->to_number<double>() : NAN;
  if (number >= range.min && number <= range.max) return number;
  fail_expected("a number" +
                within(plain(range.min), plain(range.max), range.min > kAny.min, range.max < kAny.max));
}

std::int64_t JsonPlace::integer(std::int64_t min, std::int64_t max) const {
  boost::system::error_code inexact;
  const std::int64_t number = value_->is_double() ? min : value_->to_number<std::int64_t>(inexact);
  if (!value_->is_double() && !inexact && number >= min && number <= max) return number;
  constexpr Whole kEvery;
  fail_expected("a whole number" +
                within(std::to_string(min), std::to_string(max), min > kEvery.min, max < kEvery.max));
}

std::uint64_t JsonPlace::seed() const {
  if (value_->is_uint64()) return value_->get_uint64();
  return static_cast<std::uint64_t>(integer(0, std::numeric_limits<std::int64_t>::max()));
}

bool JsonPlace::boolean() const {
  if (!value_->is_bool()) fail_expected("true or false");
  return value_->get_bool();
}

std::string JsonPlace::text() const {
  if (!value_->is_string()) fail_expected("a text");
  return {value_->get_string().data(), value_->get_string().size()};
}

std::string JsonPlace::word(const std::vector<std::string_view>& words) const {
  std::string word = text();
  if (std::ranges::find(words, word) != words.end()) return word;
  std::string all;
  for (const std::string_view known : words) all += (all.empty() ? "" : ", ") + std::string(known);
  fail("expected one of " + all + ", found " + control::json_excerpt(*value_) + renamed(word, words));
}

std::vector<JsonPlace> JsonPlace::list() const {
  if (!value_->is_array()) fail_expected("a list");
  std::vector<JsonPlace> elements;
  for (const json::value& element : value_->get_array())
    elements.emplace_back(element, path_ + "[" + std::to_string(elements.size()) + "]");
  return elements;
}

std::vector<std::pair<std::string, JsonPlace>> JsonPlace::members() const {
  if (!value_->is_object()) fail_expected("an object");
  std::vector<std::pair<std::string, JsonPlace>> members;
  for (const auto& [key, member] : value_->get_object())
    members.emplace_back(key, JsonPlace{member, (path_.empty() ? "" : path_ + ".") + std::string(key)});
  return members;
}

JsonPlace::Map::Map(const JsonPlace& place, const std::vector<std::string>& known)
    : place_{place}, object_{place.value_->if_object()} {
  if (!object_) place.fail_expected("an object");
  // Other unknown members are passed over, but one that was renamed must not be read as left out.
  for (const auto& member : *object_) {
    const std::string_view key = member.key();
    if (std::ranges::find(known, key) != known.end()) continue;
    if (const std::string renaming = renamed(key, known); !renaming.empty())
      place.fail("unknown key '" + std::string{key} + "'" + renaming);
  }
}

std::optional<JsonPlace> JsonPlace::Map::find(std::string_view key) const {
  const json::value* member = object_->if_contains({key.data(), key.size()});
  if (!member) return std::nullopt;
  return JsonPlace{*member, (place_.path_.empty() ? "" : place_.path_ + ".") + std::string(key)};
}

JsonPlace JsonPlace::Map::at(std::string_view key) const {
  if (auto member = find(key)) return *std::move(member);
  place_.fail("missing key '" + std::string(key) + "'");
}

}  // namespace truepose::record
