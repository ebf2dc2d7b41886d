#include "proto/control/json_text.hpp"

#include <boost/json/basic_parser_impl.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <boost/json/value_stack.hpp>
#include <charconv>
#include <cmath>
#include <set>
#include <vector>

#include "core/formatted.hpp"

namespace truepose::control {
namespace {

namespace json = boost::json;
constexpr std::size_t kMaxDepth = 16;

void append(std::string& out, const json::value& value);

void append(std::string& out, double number) {
  if (!std::isfinite(number)) {
    out += "null";
    return;
  }
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, number);
  const std::string_view text{digits, end};
  out += text;
  // A double stays a double for readers that tell them from integers.
  if (text.find_first_of(".e") == std::string_view::npos) out += ".0";
}

void append(std::string& out, const json::array& array) {
  out += '[';
  for (bool first = true; const json::value& element : array) {
    if (!std::exchange(first, false)) out += ',';
    append(out, element);
  }
  out += ']';
}

void append(std::string& out, const json::object& object) {
  out += '{';
  for (bool first = true; const auto& [key, element] : object) {
    if (!std::exchange(first, false)) out += ',';
    out += json::serialize(json::string_view{key});
    out += ':';
    append(out, element);
  }
  out += '}';
}

void append(std::string& out, const json::value& value) {
  switch (value.kind()) {
    case json::kind::object:
      return append(out, value.get_object());
    case json::kind::array:
      return append(out, value.get_array());
    case json::kind::double_:
      return append(out, value.get_double());
    default:
      out += json::serialize(value);
  }
}

/// The double that a number's text says, rounded once. Boost.JSON's own may differ by some units in the last
/// place.
/// @param near  Boost.JSON's, which stays where the text is too large or too small for a double
double exact(json::string_view text, double near) {
  std::from_chars(text.data(), text.data() + text.size(), near);
  return near;
}

/// Builds the value and sees what is lost in it: keys that came twice, and numbers that became infinite.
/// Stops the parse with `problem` set.
struct Builder {
  static constexpr std::size_t max_object_size = 64 * 1024;
  static constexpr std::size_t max_array_size = 64 * 1024;
  static constexpr std::size_t max_key_size = 64 * 1024;
  static constexpr std::size_t max_string_size = 64 * 1024 * 1024;

  json::value_stack values;
  std::vector<std::set<std::string, std::less<>>> keys;  ///< of the objects that are open
  std::string key;                                       ///< as far as it was read
  std::string problem;

  bool stop(json::error_code& error, std::string why) {
    problem = std::move(why);
    error = json::error::syntax;
    return false;
  }

  bool on_document_begin(json::error_code&) { return true; }
  bool on_document_end(json::error_code&) { return true; }
  bool on_object_begin(json::error_code&) {
    keys.emplace_back();
    return true;
  }
  bool on_object_end(std::size_t size, json::error_code&) {
    keys.pop_back();
    values.push_object(size);
    return true;
  }
  bool on_array_begin(json::error_code&) { return true; }
  bool on_array_end(std::size_t size, json::error_code&) {
    values.push_array(size);
    return true;
  }
  bool on_key_part(json::string_view part, std::size_t, json::error_code&) {
    key.append(part.data(), part.size());
    return true;
  }
  bool on_key(json::string_view part, std::size_t, json::error_code& error) {
    key.append(part.data(), part.size());
    if (!keys.back().insert(key).second) return stop(error, "key \"" + key + "\" appears twice");
    values.push_key(key);
    key.clear();
    return true;
  }
  bool on_string_part(json::string_view part, std::size_t, json::error_code&) {
    values.push_chars(part);
    return true;
  }
  bool on_string(json::string_view part, std::size_t, json::error_code&) {
    values.push_string(part);
    return true;
  }
  bool on_number_part(json::string_view, json::error_code&) {
    return true;
  }  // of a text that ends in a number's midst
  bool on_int64(std::int64_t number, json::string_view, json::error_code&) {
    values.push_int64(number);
    return true;
  }
  bool on_uint64(std::uint64_t number, json::string_view, json::error_code&) {
    values.push_uint64(number);
    return true;
  }
  bool on_double(double near, json::string_view text, json::error_code& error) {
    const double number = exact(text, near);
    values.push_double(number);
    return std::isfinite(number) || stop(error, "number out of range");
  }
  bool on_bool(bool value, json::error_code&) {
    values.push_bool(value);
    return true;
  }
  bool on_null(json::error_code&) {
    values.push_null();
    return true;
  }
  bool on_comment_part(json::string_view, json::error_code&) { return true; }
  bool on_comment(json::string_view, json::error_code&) { return true; }
};

}  // namespace

std::string json_text(const json::value& value) {
  std::string out;
  append(out, value);
  return out;
}

std::string json_excerpt(const json::value& value) {
  constexpr std::size_t kLongest = 40;
  std::string text = json_text(value);
  if (text.size() <= kLongest) return text;
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80)
    --end;  // not inside a UTF-8 sequence
  return text.substr(0, end) + "...";
}

std::expected<json::value, std::string> parse_json(std::string_view text) {
  json::parse_options options;
  options.max_depth = kMaxDepth;
  json::basic_parser<Builder> parser{options};
  Builder& builder = parser.handler();
  builder.values.reset();
  json::error_code error;
  const std::size_t used = parser.write_some(false, text.data(), text.size(), error);
  if (!error && used < text.size()) error = json::error::extra_data;
  if (error)
    return std::unexpected("byte " + std::to_string(used) + ": " +
                           (builder.problem.empty() ? error.message() : builder.problem));
  return builder.values.release();
}

namespace {

std::string rfc3339_of(std::chrono::sys_days day, std::chrono::milliseconds since_midnight) {
  using namespace std::chrono;
  const year_month_day date{day};
  const hh_mm_ss clock{since_midnight};
  return formatted("%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                   static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                   static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                   static_cast<int>(clock.seconds().count()), static_cast<int>(clock.subseconds().count()));
}

}  // namespace

std::string rfc3339(std::chrono::system_clock::time_point time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  return rfc3339_of(day, std::chrono::floor<std::chrono::milliseconds>(time - day));
}

std::string rfc3339(std::chrono::sys_seconds time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  return rfc3339_of(day, time - day);
}

}  // namespace truepose::control
