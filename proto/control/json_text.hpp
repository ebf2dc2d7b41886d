#pragma once

#include <boost/json/fwd.hpp>
#include <chrono>
#include <expected>
#include <string>
#include <string_view>

namespace truepose::control {

/// JSON on one line. Doubles in their shortest form that reads back the same; a number that is not finite,
/// which JSON cannot say, becomes null.
std::string json_text(const boost::json::value& value);

/// The same, short enough for a sentence.
std::string json_excerpt(const boost::json::value& value);

/// Reads one JSON text strictly: UTF-8, at most 16 levels deep, no duplicate key, every number finite.
/// A number with a fraction or an exponent, or beyond 64 bits, is the double nearest to its text.
/// @return the value, or what is wrong and where ("byte 17: key \"id\" appears twice")
std::expected<boost::json::value, std::string> parse_json(std::string_view text);

/// A time in it: UTC with milliseconds, "2026-11-21T10:48:00.123Z".
std::string rfc3339(std::chrono::system_clock::time_point time);
std::string rfc3339(std::chrono::sys_seconds time);

}  // namespace truepose::control
