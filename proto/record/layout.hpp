#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/named.hpp"

namespace boost::json {
class value;
class object;
}  // namespace boost::json

/// A record is described once: `layout(Io&, Record&)` names its members in their order, and an Io (io.hpp)
/// writes them or reads them: as JSON or as YAML.
///
///   io(key, x, how...)            a member that must be there
///   io.defaulted(key, x, how...)  written, but for an empty optional and an Unless that has its usual value;
///                                 where it is absent, x stays as it is
///   io.optional(key, x, how...)   left out where x is empty; where it is absent, x stays as it is
///   io.nullable(key, x, how...)   null where x is empty
///   io.where(c, key, x, how...)   a member that must be there where c holds, and is not there else
///   io.on_read(x, f)              f(x), where x is read
///   io.has(key, there)            whether the text has the member; when writing, `there`
///
/// `how` is the form in the text: bounds (Range, Whole, Size), a table of names, or a class with
/// `form_of(x)`, which is written, and `value_of(form)` back. A form refuses what was read by `fault(form)`:
/// one phrase, empty where nothing is wrong. With fault() alone it only checks. `read(io, x)` reads by
/// itself. What is wrong between members, `check(Io&, Record&)` says next to the layout.
///
/// Layouts of a room's own records stand in its namespace. Those of the records of core stand in this one.
namespace truepose::record {

class Io;

/// Bounds of a number, both included.
struct Range {
  double min, max;
};
/// Bounds of a whole number, both included.
struct Whole {
  std::int64_t min = std::numeric_limits<int>::min(), max = std::numeric_limits<int>::max();
};
inline constexpr Range kAny{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};
inline constexpr Range kNotNegative{0, kAny.max};
inline constexpr Whole kCount{0};
inline constexpr Whole kNumber{1};
/// Of packets, bytes and milliseconds.
inline constexpr Whole kLargeCount{0, std::numeric_limits<std::int64_t>::max()};
/// Of how many elements a list is, or of how many characters a text.
struct Size {
  std::size_t min = 0, max = std::numeric_limits<std::size_t>::max();
};
/// Bounds that keep out what no arm and no cell can be: a slip of unit or of a digit.
inline constexpr Range kMm{-100'000, 100'000}, kDeg{-360, 360}, kRad{-1e4, 1e4}, kKg{0, 100'000};

/// As it is.
struct Plain {};
/// A text that may be "", where one that must be there is not.
struct MayBeEmpty {};

/// Members of any names, in their order.
template <class T>
using ByName = std::vector<std::pair<std::string, T>>;

/// A value that is left out where it is `usual`.
template <class T>
struct Unless {
  std::remove_const_t<T> usual;
  T& value;
};

// ---- The words of a choice: a table of names, or a class that has the same three functions.

template <class Value, std::size_t N>
std::vector<std::string_view> words_of(const std::array<Named<Value>, N>& table) {
  return names_of(table);
}
template <class Value, std::size_t N>
std::string_view word_of(const std::array<Named<Value>, N>& table, const Value& value) {
  return name_of(table, value);
}
template <class Value, std::size_t N>
Value meaning_of(const std::array<Named<Value>, N>& table, std::string_view word) {
  return value_of(table, word);
}

/// A text that is one of these words.
template <std::size_t N>
struct OneOf {
  std::array<std::string_view, N> words;
};
template <class... Words>
OneOf(Words...) -> OneOf<sizeof...(Words)>;
template <std::size_t N>
std::vector<std::string_view> words_of(const OneOf<N>& one) {
  return {one.words.begin(), one.words.end()};
}
template <std::size_t N>
std::string_view word_of(const OneOf<N>&, const std::string& word) {
  return word;
}
template <std::size_t N>
std::string meaning_of(const OneOf<N>&, std::string_view word) {
  return std::string{word};
}

template <class How, class T>
concept WordsOf = requires(const How& how, const T& x) {
  word_of(how, x);
};
template <class How, class T>
concept FormOf = requires(const How& how, const T& x) {
  how.form_of(x);
};
template <class How, class T>
concept Checks = requires(const How& how, const T& x) {
  std::string{how.fault(x)};
};

template <class T, template <class...> class Template>
inline constexpr bool kIsA = false;
template <template <class...> class Template, class... Args>
inline constexpr bool kIsA<Template<Args...>, Template> = true;

template <class T>
inline constexpr bool kIsByName = false;
template <class T>
inline constexpr bool kIsByName<ByName<T>> = true;
template <class T>
inline constexpr bool kIsArray = false;
template <std::size_t N>
inline constexpr bool kIsArray<std::array<double, N>> = true;
template <class T>
concept EigenVector = std::derived_from<T, Eigen::MatrixBase<T>> && T::ColsAtCompileTime == 1;

template <class T>
concept AnyJson = std::same_as<T, boost::json::value> || std::same_as<T, boost::json::object>;

/// Whether it holds no value of its own.
template <class T>
bool is_left_out(const T& x) {
  if constexpr (kIsA<T, std::optional>) {
    return !x;
  } else if constexpr (kIsA<T, Unless>) {
    return x.value == x.usual;
  } else {
    return false;
  }
}

template <class T>
bool is_empty(const T& x) {
  if constexpr (kIsA<T, std::optional> || kIsA<T, Unless>) {
    return is_left_out(x);
  } else if constexpr (requires { x.size(); }) {
    return x.size() == 0;
  } else if constexpr (requires { x == nullptr; }) {
    return x == nullptr;
  } else {
    return false;
  }
}

}  // namespace truepose::record
