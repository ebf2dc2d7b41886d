#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace truepose::sim::krl {

/// A constant of an enumeration, in capitals: #T1 is Literal{"T1"}.
struct Literal {
  std::string name;
  bool operator==(const Literal&) const = default;
};

struct Value;

/// The elements of an array, or the components of a structure in the order of its declaration.
using Parts = std::vector<Value>;

/// A value of KRL; std::monostate where a variable never got one. A CHAR array is one string as long as the
/// array,
/// '\0' where no character was set.
struct Value : std::variant<std::monostate, std::int32_t, double, bool, char, Literal, std::string, Parts> {
  using variant::variant;
};

/// The characters of a CHAR array up to the first that was not set; empty for any other value.
std::string text_of(const Value& value);

/// Puts a text into a CHAR array: what is left of that is not set. @return whether it has room
bool fill(std::string& array, std::string_view text);

/// Whether at least a part of it was set.
bool is_set(const Value& value);

/// A number that is INT or REAL. @pre it is one of them
double number_of(const Value& value);

}  // namespace truepose::sim::krl
