#pragma once

#include <Eigen/Core>
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

/// A record is described once: `layout(io, record)` names its members in their order, and an `io` writes them
/// or reads them. ReadIo and WriteIo do so for any text that has numbers, texts, lists and maps: JsonPlace
/// and JsonText, YamlValue and YamlText.
///
///   io(key, x, how...)            a member that must be there
///   io.defaulted(key, x, how...)  always written; where it is absent, x stays as it is
///   io.optional(key, x, how...)   left out where x is empty; where it is absent, x stays as it is
///   io.on_read(x, f)              f(x), where x is read
///   io.has(key, there)            whether the text has the member; when writing, `there`
///
/// `how` is how the text says it: bounds (Range, Whole), a table of names, or a form: a class with
/// `form_of(x)`, that which is written, and `value_of(form)` back. A form may refuse what was read by
/// `fault(form)`, one phrase, empty where there is none; with fault() alone it only checks. `how` may also
/// read by itself: `read(text, x)`. What is found wrong between members, `check(io, record)` says behind the
/// layout.
namespace truepose::record {

/// T or const T, so that one layout reads and writes.
template <class T, class Record>
concept Is = std::same_as<std::remove_const_t<T>, Record>;

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
concept EigenVector = std::derived_from<T, Eigen::MatrixBase<T>> && T::ColsAtCompileTime == 1;

template <class T>
bool is_empty(const T& x) {
  if constexpr (requires { x.has_value(); }) {
    return !x.has_value();
  } else if constexpr (requires { x.size(); }) {
    return x.size() == 0;
  } else if constexpr (kIsA<T, Unless>) {
    return x.value == x.usual;
  } else if constexpr (requires { x == nullptr; }) {
    return x == nullptr;
  } else {
    return false;
  }
}

/// Writes a record. `Text` says what the text makes of it: Value, number(), whole(), seed(), boolean(),
/// text(), word(), list() and record().
template <class Text>
class WriteIo {
 public:
  using Value = typename Text::Value;

  template <class T, class... How>
  void operator()(std::string_view key, const T& x, const How&... how) {
    members_.emplace_back(key, value(x, how...));
  }
  template <class T, class... How>
  void defaulted(std::string_view key, const T& x, const How&... how) {
    (*this)(key, x, how...);
  }
  template <class T, class... How>
  void optional(std::string_view key, const T& x, const How&... how) {
    if (!record::is_empty(x)) (*this)(key, x, how...);
  }
  void on_read(const auto&, const auto&) {}
  bool has(std::string_view, bool there) const { return there; }

  template <class T, class First = Plain, class... Rest>
  static Value value(const T& x, const First& first = {}, const Rest&... rest) {
    if constexpr (FormOf<First, T>) {
      return value(first.form_of(x), rest...);
    } else if constexpr (WordsOf<First, T>) {
      return Text::word(word_of(first, x));
    } else if constexpr (kIsA<T, std::optional>) {
      return value(*x, first, rest...);
    } else if constexpr (kIsA<T, Unless>) {
      return value(x.value, first, rest...);
    } else if constexpr (Checks<First, T>) {
      return value(x, rest...);
    } else {
      return plain(x, first, rest...);
    }
  }

 private:
  template <class T, class... How>
  static Value plain(const T& x, const How&... how) {
    if constexpr (kIsByName<T> || kIsA<T, std::map>) {
      std::vector<std::pair<std::string, Value>> members;
      for (const auto& [key, member] : x) members.emplace_back(key, value(member, how...));
      return Text::record(std::move(members));
    } else if constexpr (kIsA<T, std::vector> || EigenVector<T>) {
      std::vector<Value> elements;
      for (const auto& element : x) elements.push_back(value(element, how...));
      return Text::list(std::move(elements));
    } else if constexpr (std::same_as<T, bool>) {
      return Text::boolean(x);
    } else if constexpr (std::same_as<T, std::uint64_t>) {
      return Text::seed(x);
    } else if constexpr (std::integral<T>) {
      return Text::whole(static_cast<std::int64_t>(x));
    } else if constexpr (kIsA<T, std::chrono::duration>) {
      return Text::whole(static_cast<std::int64_t>(x.count()));
    } else if constexpr (std::floating_point<T>) {
      return Text::number(x);
    } else if constexpr (std::convertible_to<T, std::string_view>) {
      return Text::text(x);
    } else {
      WriteIo io;
      layout(io, x);
      return Text::record(std::move(io.members_));
    }
  }

  std::vector<std::pair<std::string, Value>> members_;
};

/// Knows the keys of a record.
template <class Place>
class KeysIo {
 public:
  void operator()(std::string_view key, const auto&...) { keys.emplace_back(key); }
  void defaulted(std::string_view key, const auto&...) { keys.emplace_back(key); }
  void optional(std::string_view key, const auto&...) { keys.emplace_back(key); }
  void on_read(const auto&, const auto&) {}
  bool has(std::string_view, bool there) const { return there; }

  std::vector<std::string> keys;
};

/// Reads a record. `Place` is a value of the text that knows where it stands, and throws from fail():
/// number(), integer(), boolean(), text(), word(), list(), members(), and a Map of keys with find() and at().
template <class Place>
class ReadIo {
 public:
  template <class Record>
  ReadIo(const Place& place, Record& x) : map_{place, keys_of(x)} {}

  template <class T, class... How>
  void operator()(std::string_view key, T&& x, const How&... how) {
    read(map_.at(key), x, how...);
  }
  template <class T, class... How>
  void defaulted(std::string_view key, T&& x, const How&... how) {
    if (const auto place = map_.find(key)) read(*place, x, how...);
  }
  template <class T, class... How>
  void optional(std::string_view key, T&& x, const How&... how) {
    defaulted(key, x, how...);
  }
  void on_read(auto& x, const auto& f) { f(x); }
  bool has(std::string_view key, bool) const { return map_.find(key) ? true : false; }

  /// The value of a member, to say what is wrong with it.
  decltype(auto) at(std::string_view key) const { return map_.at(key); }
  const Place& place() const { return map_.value(); }

  template <class T, class First = Plain, class... Rest>
  static void read(const Place& place, T& x, const First& first = {}, const Rest&... rest) {
    if constexpr (requires { first.read(place, x); }) {
      first.read(place, x);
    } else if constexpr (FormOf<First, T>) {
      auto form = first.form_of(x);
      read(place, form, rest...);
      refuse(place, first, form);
      x = first.value_of(form);
    } else if constexpr (WordsOf<First, T>) {
      x = meaning_of(first, place.word(words_of(first)));
    } else if constexpr (kIsA<T, std::optional>) {
      read(place, x.emplace(), first, rest...);
    } else if constexpr (kIsA<T, Unless>) {
      read(place, x.value, first, rest...);
    } else if constexpr (Checks<First, T>) {
      read(place, x, rest...);
      refuse(place, first, x);
    } else {
      plain(place, x, first, rest...);
    }
  }

 private:
  template <class Record>
  static std::vector<std::string> keys_of(Record& x) {
    KeysIo<Place> io;
    layout(io, x);
    return std::move(io.keys);
  }

  template <class How, class T>
  static void refuse(const Place& place, const How& how, const T& x) {
    if constexpr (Checks<How, T>) {
      if (const std::string fault{how.fault(x)}; !fault.empty()) place.fail(fault);
    }
  }

  template <class T, class... How>
  static void plain(const Place& place, T& x, const How&... how) {
    if constexpr (kIsByName<T>) {
      x.clear();
      for (const auto& [key, member] : place.members())
        read(member, x.emplace_back(key, typename T::value_type::second_type{}).second, how...);
    } else if constexpr (kIsA<T, std::map>) {
      x.clear();
      for (const auto& [key, member] : place.members()) read(member, x[key], how...);
    } else if constexpr (kIsA<T, std::vector>) {
      x.clear();
      for (const auto& element : place.list()) read(element, x.emplace_back(), how...);
    } else if constexpr (EigenVector<T>) {
      std::vector<double> numbers;
      plain(place, numbers, how...);
      const auto size = static_cast<Eigen::Index>(numbers.size());
      if (T::SizeAtCompileTime != Eigen::Dynamic && size != T::SizeAtCompileTime)
        place.fail("expected " + std::to_string(T::SizeAtCompileTime) + " numbers, found " +
                   std::to_string(size));
      if (T::MaxSizeAtCompileTime != Eigen::Dynamic && size > T::MaxSizeAtCompileTime)
        place.fail("expected at most " + std::to_string(T::MaxSizeAtCompileTime) + " numbers, found " +
                   std::to_string(size));
      x = Eigen::Map<const Eigen::VectorXd>(numbers.data(), size);
    } else if constexpr (std::same_as<T, bool>) {
      x = place.boolean();
    } else if constexpr (std::same_as<T, std::uint64_t> && !(std::same_as<How, Whole> || ...)) {
      x = place.seed();
    } else if constexpr (std::integral<T>) {
      x = whole<T>(place, how...);
    } else if constexpr (kIsA<T, std::chrono::duration>) {
      x = T{whole<typename T::rep>(place, how...)};
    } else if constexpr (std::floating_point<T>) {
      x = number(place, how...);
    } else if constexpr (std::same_as<T, std::string>) {
      x = text(place, how...);
    } else if constexpr (std::same_as<T, std::filesystem::path>) {
      x = place.file();
    } else {
      ReadIo io{place, x};
      layout(io, x);
      if constexpr (requires { check(io, x); }) check(io, x);
    }
  }

  static double number(const Place& place, Plain) { return place.number(kAny); }
  static double number(const Place& place, Range range) { return place.number(range); }
  template <class T>
  static T whole(const Place& place, Plain) {
    return whole<T>(place, Whole{});
  }
  template <class T>
  static T whole(const Place& place, Whole range) {
    return static_cast<T>(place.integer(range.min, range.max));
  }
  static std::string text(const Place& place, Plain) { return place.text(); }
  static std::string text(const Place& place, MayBeEmpty) { return place.text_or_empty(); }

  typename Place::Map map_;
};

}  // namespace truepose::record
