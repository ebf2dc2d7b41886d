#include "proto/control/param_reader.hpp"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <utility>

#include "proto/control/json_text.hpp"
#include "proto/text/renamed.hpp"

namespace truepose::control {
namespace {

namespace json = boost::json;

std::string plain(double number) { return json_text(json::value(number)); }

/// A whole number that fits, whichever way it is kept.
std::optional<std::int64_t> whole(const json::value& value) {
  if (value.is_int64()) return value.get_int64();
  if (value.is_uint64() && std::in_range<std::int64_t>(value.get_uint64()))
    return static_cast<std::int64_t>(value.get_uint64());
  return std::nullopt;
}

/// As JSON Schema counts them. What was parsed is UTF-8.
std::size_t characters(std::string_view text) {
  const auto begins_one = [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; };
  return static_cast<std::size_t>(std::ranges::count_if(text, begins_one));
}

std::string path_of(std::string_view key) { return "params." + std::string{key}; }

}  // namespace

const json::value* ParamReader::find(std::string_view key) {
  known_.emplace(key);
  return params_.if_contains(json::string_view{key.data(), key.size()});
}

void ParamReader::fail(std::string_view key, std::string_view reason) {
  if (error_) return;
  const std::string path = path_of(key);
  error_ = RpcError{ErrorCode::InvalidParams, path + ": " + std::string{reason}, path};
}

void ParamReader::expected(std::string_view key, std::string_view what, const json::value& found) {
  fail(key, "expected " + std::string{what} + ", found " + json_excerpt(found));
}

void ParamReader::fail_missing(std::string_view key) { fail(key, "is missing"); }

std::optional<std::int64_t> ParamReader::integer(std::string_view key, std::int64_t min, std::int64_t max) {
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  if (const auto number = whole(*value); number && *number >= min && *number <= max) return number;
  expected(key, "an integer " + std::to_string(min) + ".." + std::to_string(max), *value);
  return std::nullopt;
}

std::optional<double> ParamReader::number(std::string_view key, double min, double max) {
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  if (value->is_number()) {
    const double number = value->to_number<double>();
    if (number >= min && number <= max) return number;
  }
  expected(key, "a number " + plain(min) + ".." + plain(max), *value);
  return std::nullopt;
}

std::optional<bool> ParamReader::boolean(std::string_view key) {
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  if (value->is_bool()) return value->get_bool();
  expected(key, "true or false", *value);
  return std::nullopt;
}

std::optional<std::string> ParamReader::text(std::string_view key, std::size_t max_size) {
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  if (value->is_string() && characters(value->get_string()) <= max_size)
    return std::string{value->get_string().data(), value->get_string().size()};
  expected(key, "a string of at most " + std::to_string(max_size) + " characters", *value);
  return std::nullopt;
}

std::optional<std::string> ParamReader::id(std::string_view key) {
  constexpr std::size_t kLongest = 64;
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  if (value->is_string() && !value->get_string().empty()) return text(key, kLongest);
  expected(key, "an id", *value);
  return std::nullopt;
}

std::optional<std::vector<std::string>> ParamReader::texts(std::string_view key) {
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  std::vector<std::string> texts;
  if (value->is_array())
    for (const json::value& element : value->get_array())
      if (element.is_string()) texts.emplace_back(element.get_string().data(), element.get_string().size());
  const std::set<std::string> distinct{texts.begin(), texts.end()};
  if (value->is_array() && distinct.size() == value->get_array().size()) return texts;
  expected(key, "a list of distinct strings", *value);
  return std::nullopt;
}

std::optional<std::vector<int>> ParamReader::integers(std::string_view key, int min, int max,
                                                      std::size_t max_size) {
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  std::vector<int> integers;
  if (value->is_array() && value->get_array().size() <= max_size)
    for (const json::value& element : value->get_array())
      if (const auto number = whole(element); number && *number >= min && *number <= max)
        integers.push_back(static_cast<int>(*number));
  if (value->is_array() && integers.size() == value->get_array().size()) return integers;
  expected(key,
           "a list of at most " + std::to_string(max_size) + " integers " + std::to_string(min) + ".." +
               std::to_string(max),
           *value);
  return std::nullopt;
}

std::optional<std::vector<std::vector<double>>> ParamReader::rows(std::string_view key, std::size_t columns,
                                                                  std::size_t max_rows) {
  const json::value* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_array() || value->get_array().empty() || value->get_array().size() > max_rows) {
    expected(key, "a list of 1.." + std::to_string(max_rows) + " rows", *value);
    return std::nullopt;
  }
  std::vector<std::vector<double>> rows;
  for (const json::value& element : value->get_array()) {
    const json::array* row = element.if_array();
    const auto is_number = [](const json::value& number) { return number.is_number(); };
    if (!row || row->size() != columns || !std::ranges::all_of(*row, is_number)) {
      expected(std::string{key} + "[" + std::to_string(rows.size()) + "]",
               std::to_string(columns) + " numbers", element);
      return std::nullopt;
    }
    auto& numbers = rows.emplace_back();
    for (const json::value& number : *row) numbers.push_back(number.to_number<double>());
  }
  return rows;
}

std::optional<RpcError> ParamReader::finish() {
  finished_ = true;
  for (const auto& member : params_) {
    const std::string key{member.key().data(), member.key().size()};
    if (!known_.contains(key)) fail(key, "unknown parameter" + renamed(key, known_));
  }
  return error_;
}

}  // namespace truepose::control
