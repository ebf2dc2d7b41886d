#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <string>
#include <string_view>

namespace truepose::world {

/// Of an answer of the control port: whether the daemon carried the request out.
inline bool is_result(const boost::json::value& answer) {
  return answer.is_object() && answer.as_object().contains("result");
}

inline const boost::json::object& result_of(const boost::json::value& answer) {
  return answer.as_object().at("result").as_object();
}

/// Empty where it is no text.
inline std::string text_at(const boost::json::object& object, std::string_view member) {
  const boost::json::value* const value = object.if_contains(member);
  return value != nullptr && value->is_string() ? std::string{value->as_string()} : std::string{};
}

/// "E_STATE"; "ok" of a result; empty where the session ended before.
inline std::string outcome_of(const boost::json::value& answer) {
  if (!answer.is_object()) return {};
  if (is_result(answer)) return "ok";
  return text_at(answer.as_object().at("error").as_object().at("data").as_object(), "code");
}

}  // namespace truepose::world
