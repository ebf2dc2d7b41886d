#pragma once

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/record/layout.hpp"

namespace truepose::record {

/// How a member stands in a text.
enum class Presence {
  Required,   ///< always written; reading refuses a text without it
  Defaulted,  ///< written unless it is left out; reading leaves the value where the text has none
  Optional,   ///< written where it is not empty; reading leaves the value where the text has none
  Nullable,   ///< written as null where it is empty; reading leaves the value at null and where there is none
};

/// A text that is being written or read, at one value of it. `layout(io, record)` names a record's members,
/// once for every text: each text is a class of its own that implements what is virtual here.
///
/// A layout changes the record where the text is read, and only there.
class Io {
 public:
  Io() = default;
  Io(const Io&) = delete;
  Io& operator=(const Io&) = delete;
  virtual ~Io() = default;

  template <class T, class... How>
  void operator()(std::string_view key, T&& x, const How&... how) {
    member(Presence::Required, key, true, x, how...);
  }
  template <class T, class... How>
  void defaulted(std::string_view key, T&& x, const How&... how) {
    member(Presence::Defaulted, key, !is_left_out(x), x, how...);
  }
  template <class T, class... How>
  void optional(std::string_view key, T&& x, const How&... how) {
    member(Presence::Optional, key, !record::is_empty(x), x, how...);
  }
  template <class T, class... How>
  void nullable(std::string_view key, T&& x, const How&... how) {
    member(Presence::Nullable, key, !record::is_empty(x), x, how...);
  }
  template <class T, class... How>
  void where(bool is_of_record, std::string_view key, T&& x, const How&... how) {
    if (describes()) return optional(key, x, how...);
    if (is_of_record) member(Presence::Required, key, true, x, how...);
  }
  void on_read(auto& x, const auto& f) {
    if (reads()) f(x);
  }

  /// The value where the text stands: `how` says its form, as of a member.
  template <class T, class First = Plain, class... Rest>
  void value(T& x, const First& first = {}, const Rest&... rest) {
    if constexpr (ReadsItself<First, T>) {
      if (reads() || describes()) return first.read(*this, x);
    }
    if constexpr (FormOf<First, T>) {
      auto form = first.form_of(x);
      value(form, rest...);
      refuse(first, form);
      if constexpr (requires { x = first.value_of(form); }) {
        if (reads()) x = first.value_of(form);
      }
    } else if constexpr (WordsOf<First, T>) {
      if (describes()) return describe_words(words_of(first));
      if (!reads()) return write_word(word_of(first, x));
      x = meaning_of(first, read_word(words_of(first)));
    } else if constexpr (ReadsItself<First, T>) {
      std::abort();  // a form that reads by itself and has no form_of() cannot be written
    } else if constexpr (kIsA<T, std::optional>) {
      if (describes()) {
        auto usual = x.value_or(typename T::value_type{});
        return value(usual, first, rest...);
      }
      value(reads() ? x.emplace() : *x, first, rest...);
    } else if constexpr (kIsA<T, Unless>) {
      value(x.value, first, rest...);
    } else if constexpr (Checks<First, T>) {
      value(x, rest...);
      refuse(first, x);
    } else {
      plain(x, first, rest...);
    }
  }

  virtual bool reads() const = 0;

  // For a schema alone: what a reader of the document wants to know, and the types do not say.
  /// Of the record. @param name  under which it stands once in the schema; empty: where it is used
  virtual void record(std::string_view name, std::string_view description = {}) {
    static_cast<void>(name), static_cast<void>(description);
  }
  /// Of the next member.
  virtual Io& about(std::string_view) { return *this; }
  /// The next member is a text of this format.
  virtual Io& format(std::string_view) { return *this; }
  /// The next member is described by the schema of this name, which another file defines.
  virtual Io& refers(std::string_view) { return *this; }
  /// The document has members that are not read here.
  virtual void further_members() {}

  /// Whether the text has the member; when writing, `there`.
  virtual bool has(std::string_view key, bool there) const = 0;
  /// Refuses the value where the text stands, or a member of it. Reading alone.
  [[noreturn]] virtual void fail(const std::string& what) const = 0;
  [[noreturn]] virtual void fail_at(std::string_view key, const std::string& what) const = 0;
  [[noreturn]] virtual void fail_at(std::string_view key, std::size_t element,
                                    const std::string& what) const = 0;
  /// Refuses a value without this member.
  virtual void require(std::string_view key) const = 0;

 protected:
  // Going into a text and out again. `leave` ends what `enter` and the elements began.
  /// @return whether there is a value to write or to read
  virtual bool enter(Presence presence, std::string_view key, bool there) = 0;
  /// @param keys  hands every key of the record's layout to an Io
  virtual void begin_record(const std::function<void(Io&)>& keys) = 0;
  virtual void end_record() = 0;
  /// @param size  when writing  @return that of the text
  virtual std::size_t begin_list(std::size_t size) = 0;
  virtual void enter_element(std::size_t i) = 0;
  virtual void end_list() = 0;
  /// A record of any keys, likewise.
  virtual std::size_t begin_members(std::size_t size) = 0;
  /// @param key  when writing  @return that of the text
  virtual std::string enter_member(std::size_t i, std::string_view key) = 0;
  virtual void end_members() = 0;
  virtual void leave() = 0;

  // Values: x is written, or becomes what is read.
  virtual void number(double& x, Range range) = 0;
  virtual void whole(std::int64_t& x, Whole range) = 0;
  virtual void seed(std::uint64_t& x) = 0;
  virtual void boolean(bool& x) = 0;
  virtual void text(std::string& x, bool may_be_empty) = 0;
  virtual void file(std::filesystem::path& x) = 0;
  virtual void write_word(std::string_view word) = 0;
  virtual std::string read_word(const std::vector<std::string_view>& words) = 0;
  /// Any value of JSON, and any object: what has no layout. Not in YAML.
  virtual void json(boost::json::value& x);
  virtual void json(boost::json::object& x);
  /// The element of a list where the text stands may be null. @param is_null  when writing
  /// @return whether it is
  virtual bool null_element(bool is_null);

  // A schema is made from empty records: lists and what may be left out have one value to describe.
  virtual bool describes() const { return false; }
  virtual void describe_words(const std::vector<std::string_view>&) {}
  /// The list or the text that is under way has so many elements or characters.
  virtual void describe_size(Size) {}

 private:
  template <class How, class T>
  static constexpr bool ReadsItself = requires(const How& how, Io& io, T& x) {
    how.read(io, x);
  };

  template <class T, class... How>
  void member(Presence presence, std::string_view key, bool there, T& x, const How&... how) {
    if (!enter(presence, key, there)) return;
    value(x, how...);
    leave();
  }

  template <class How, class T>
  void refuse(const How& how, const T& x) const {
    if constexpr (Checks<How, T>) {
      if (!reads()) return;
      if (const std::string fault{how.fault(x)}; !fault.empty()) fail(fault);
    }
  }

  template <class T, class... How>
  void plain(T& x, const How&... how) {
    if constexpr (kIsByName<T> || kIsA<T, std::map>) {
      members(x, how...);
    } else if constexpr (kIsA<T, std::vector>) {
      list(x, how...);
    } else if constexpr (EigenVector<T>) {
      vector(x, how...);
    } else if constexpr (kIsArray<T>) {
      array(x, how...);
    } else if constexpr (std::same_as<T, bool>) {
      boolean(x);
    } else if constexpr (std::same_as<T, std::uint64_t> && !(std::same_as<How, Whole> || ...)) {
      seed(x);
    } else if constexpr (std::integral<T>) {
      auto number = static_cast<std::int64_t>(x);
      whole(number, bounds<Whole>(how...));
      if (reads()) x = static_cast<T>(number);
    } else if constexpr (kIsA<T, std::chrono::duration>) {
      auto count = static_cast<std::int64_t>(x.count());
      whole(count, bounds<Whole>(how...));
      if (reads()) x = T{static_cast<typename T::rep>(count)};
    } else if constexpr (std::same_as<T, double>) {
      number(x, bounds<Range>(how...));
    } else if constexpr (std::same_as<T, std::filesystem::path>) {
      file(x);
    } else if constexpr (std::same_as<T, std::string>) {
      text(x, (std::same_as<How, MayBeEmpty> || ...));
      (sized(
           how, [&x] { return characters(x); }, "characters"),
       ...);
    } else if constexpr (AnyJson<T>) {
      json(x);
    } else {
      begin_record([&](Io& keys) { layout(keys, x); });
      layout(*this, x);
      if constexpr (requires { check(*this, x); }) {
        if (reads()) check(*this, x);
      }
      end_record();
    }
  }

  /// Bounds where `how` gives some.
  template <class Bounds, class First, class... Rest>
  static Bounds bounds(const First& first, const Rest&...) {
    if constexpr (std::same_as<First, Bounds>)
      return first;
    else if constexpr (std::same_as<Bounds, Range>)
      return kAny;
    else
      return {};
  }

  /// Of a text in UTF-8.
  static std::size_t characters(std::string_view text);
  /// Refuses a list or a text of another size, or describes the size.
  void sized(Size size, const auto& count, std::string_view what) {
    if (describes()) describe_size(size);
    if (reads()) refuse_size(count(), size, what);
  }
  static void sized(const auto&, const auto&, std::string_view) {}
  void refuse_size(std::size_t found, Size size, std::string_view what) const;

  /// Its size stands before the form of its elements.
  template <class T, class... How>
  void list(T& x, const Size& size, const How&... how) {
    elements(x, how...);
    sized(
        size, [&x] { return x.size(); }, "elements");
  }
  template <class T, class... How>
  void list(T& x, const How&... how) {
    elements(x, how...);
  }
  template <class T, class... How>
  void elements(T& x, const How&... how) {
    const std::size_t size = begin_list(x.size());
    if (describes()) return describe_one<typename T::value_type>(how...);
    if (reads()) x.clear();
    for (std::size_t i = 0; i < size; ++i) {
      enter_element(i);
      if constexpr (std::same_as<typename T::value_type, bool>) {
        bool one = !reads() && x[i];  // a list of these has no references to its elements
        value(one);
        if (reads()) x.push_back(one);
      } else {
        element(reads() ? x.emplace_back() : x[i], how...);
      }
      leave();
    }
    end_list();
  }
  template <class T, class... How>
  void element(T& x, const How&... how) {
    if constexpr (kIsA<T, std::optional>) {
      if (null_element(!x.has_value())) return;
    }
    value(x, how...);
  }

  template <class T, class... How>
  void describe_one(const How&... how) {
    T one{};
    enter_element(0);
    element(one, how...);
    leave();
  }

  template <class T, class... How>
  void members(T& x, const How&... how) {
    const std::size_t size = begin_members(x.size());
    if (describes()) return describe_one<typename T::value_type::second_type>(how...);
    if (reads()) x.clear();
    auto next = x.begin();
    for (std::size_t i = 0; i < size; ++i) {
      const std::string key = enter_member(i, reads() ? std::string_view{} : std::string_view{next->first});
      if constexpr (kIsByName<T>) {
        value(reads() ? x.emplace_back(key, typename T::value_type::second_type{}).second : next++->second,
              how...);
      } else {
        value(reads() ? x[key] : next++->second, how...);
      }
      leave();
    }
    end_members();
  }

  template <std::size_t N, class... How>
  void array(std::array<double, N>& x, const How&... how) {
    std::vector<double> numbers(x.begin(), x.end());
    list(numbers, Size{N, N}, how...);
    if (reads()) std::ranges::copy(numbers, x.begin());
  }

  template <class T, class... How>
  void vector(T& x, const How&... how) {
    std::vector<double> numbers(x.begin(), x.end());
    list(numbers, how...);
    constexpr int kSize = T::SizeAtCompileTime, kMost = T::MaxSizeAtCompileTime;
    if (describes() && kMost != Eigen::Dynamic)
      describe_size({static_cast<std::size_t>(std::max(kSize, 0)), static_cast<std::size_t>(kMost)});
    if (!reads()) return;
    const auto size = static_cast<Eigen::Index>(numbers.size());
    if (T::SizeAtCompileTime != Eigen::Dynamic && size != T::SizeAtCompileTime)
      fail("expected " + std::to_string(T::SizeAtCompileTime) + " numbers, found " + std::to_string(size));
    if (T::MaxSizeAtCompileTime != Eigen::Dynamic && size > T::MaxSizeAtCompileTime)
      fail("expected at most " + std::to_string(T::MaxSizeAtCompileTime) + " numbers, found " +
           std::to_string(size));
    x = Eigen::Map<const Eigen::VectorXd>(numbers.data(), size);
  }
};

/// What is common to every Io that does not read: nothing is refused, and what it does not use is passed
/// over.
class WriteIo : public Io {
 public:
  bool reads() const override { return false; }
  bool has(std::string_view, bool there) const override { return there; }
  [[noreturn]] void fail(const std::string&) const override;
  [[noreturn]] void fail_at(std::string_view, const std::string&) const override;
  [[noreturn]] void fail_at(std::string_view, std::size_t, const std::string&) const override;
  void require(std::string_view) const override {}

 protected:
  void leave() override {}
  void begin_record(const std::function<void(Io&)>&) override {}
  void end_record() override {}
  std::size_t begin_list(std::size_t size) override { return size; }
  void enter_element(std::size_t) override {}
  void end_list() override {}
  std::size_t begin_members(std::size_t size) override { return size; }
  std::string enter_member(std::size_t, std::string_view) override { return {}; }
  void end_members() override {}
  void number(double&, Range) override {}
  void whole(std::int64_t&, Whole) override {}
  void seed(std::uint64_t&) override {}
  void boolean(bool&) override {}
  void text(std::string&, bool) override {}
  void file(std::filesystem::path&) override {}
  void write_word(std::string_view) override {}
  [[noreturn]] std::string read_word(const std::vector<std::string_view>&) override;
};

/// The keys of a record, in their order.
std::vector<std::string> keys_of(const std::function<void(Io&)>& layout);

}  // namespace truepose::record
