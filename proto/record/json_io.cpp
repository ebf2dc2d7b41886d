#include "proto/record/json_io.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "proto/control/json_text.hpp"
#include "proto/text/renamed.hpp"

namespace truepose::record {
namespace {

namespace json = boost::json;

json::string_view view(std::string_view text) { return {text.data(), text.size()}; }

/// Writes a value of JSON. Every value under way stands in the one before it.
class JsonWriter final : public WriteIo {
 public:
  json::value document;

 private:
  bool enter(Presence presence, std::string_view key, bool there) override {
    if (!there && presence != Presence::Nullable) return false;
    json::value& member = top().get_object()[view(key)];
    if (!there) return false;
    path_.push_back(&member);
    return true;
  }
  void leave() override { path_.pop_back(); }
  void begin_record(const std::function<void(Io&)>&) override { top().emplace_object(); }
  std::size_t begin_list(std::size_t size) override {
    top().emplace_array().resize(size);
    return size;
  }
  void enter_element(std::size_t i) override { path_.push_back(&top().get_array()[i]); }
  std::size_t begin_members(std::size_t size) override {
    top().emplace_object();
    return size;
  }
  std::string enter_member(std::size_t, std::string_view key) override {
    path_.push_back(&top().get_object()[view(key)]);
    return {};
  }

  void number(double& x, Range) override { top() = x; }
  void whole(std::int64_t& x, Whole) override { top() = x; }
  void seed(std::uint64_t& x) override { top() = x; }
  void boolean(bool& x) override { top() = x; }
  void text(std::string& x, bool) override { top() = x; }
  void file(std::filesystem::path& x) override { top() = x.string(); }
  void write_word(std::string_view word) override { top() = view(word); }
  void json(json::value& x) override { top() = x; }
  void json(json::object& x) override { top() = x; }
  bool null_element(bool is_null) override { return is_null; }

  json::value& top() { return *path_.back(); }

  std::vector<json::value*> path_{&document};
};

struct RecordError : std::runtime_error {
  RecordError(const std::string& where, const std::string& what)
      : std::runtime_error{(where.empty() ? "" : where + ": ") + what}, place{where} {}

  std::string place;
};

std::string digits(double number) { return control::json_text(json::value(number)); }

/// "of 0 or more", "1..100"; nothing where there is no bound.
std::string within(const std::string& min, const std::string& max, bool has_min, bool has_max) {
  if (has_min && has_max) return " " + min + ".." + max;
  return has_min ? " of " + min + " or more" : "";
}

/// Reads a value of JSON. Every error is a RecordError "points[3].pose: what".
class JsonReader final : public Io {
 public:
  JsonReader(const json::value& document, const std::string& name, Others others)
      : refuses_others_{others == Others::Refused} {
    path_.push_back({&document, name});
  }

  bool reads() const override { return true; }
  bool has(std::string_view key, bool) const override { return find(key) != nullptr; }
  [[noreturn]] void fail(const std::string& what) const override { fail_in(where(), what); }
  [[noreturn]] void fail_at(std::string_view key, const std::string& what) const override {
    require(key);
    fail_in(below(where(), key), what);
  }
  [[noreturn]] void fail_at(std::string_view key, std::size_t element,
                            const std::string& what) const override {
    fail_in(below(where(), key) + "[" + std::to_string(element) + "]", what);
  }
  void require(std::string_view key) const override {
    if (find(key)) return;
    if (refuses_others_) fail_in(below(where(), key), "is missing");
    fail("missing key '" + std::string(key) + "'");
  }

 private:
  struct Step {
    const json::value* value;
    std::string key;          ///< of a member, the whole's name first
    std::size_t element = 0;  ///< of a list, where there is no key
  };

  bool enter(Presence presence, std::string_view key, bool) override {
    const json::value* const member = find(key);
    if (!member && presence == Presence::Required) require(key);
    if (!member || (presence == Presence::Nullable && member->is_null())) return false;
    path_.push_back({member, std::string{key}});
    return true;
  }
  void leave() override { path_.pop_back(); }
  /// Where unknown members are passed over, one that was renamed must not be read as left out.
  void begin_record(const std::function<void(Io&)>& layout) override {
    if (!value().is_object()) fail_expected("an object");
    const std::vector<std::string> known = keys_of(layout);
    for (const auto& member : value().get_object()) {
      const std::string_view key = member.key();
      if (std::ranges::find(known, key) != known.end()) continue;
      const std::string renaming = renamed(key, known);
      if (refuses_others_) fail_in(below(where(), key), "unknown parameter" + renaming);
      if (!renaming.empty()) fail("unknown key '" + std::string{key} + "'" + renaming);
    }
  }
  void end_record() override {}
  std::size_t begin_list(std::size_t) override {
    if (!value().is_array()) fail_expected("a list");
    return value().get_array().size();
  }
  void enter_element(std::size_t i) override { path_.push_back({&value().get_array()[i], {}, i}); }
  void end_list() override {}
  std::size_t begin_members(std::size_t) override {
    if (!value().is_object()) fail_expected("an object");
    return value().get_object().size();
  }
  std::string enter_member(std::size_t i, std::string_view) override {
    const auto& member = value().get_object().begin()[i];
    path_.push_back({&member.value(), std::string{member.key()}});
    return path_.back().key;
  }
  void end_members() override {}

  void number(double& x, Range range) override {
    x = value().is_number() ? value().to_number<double>() : NAN;
    if (x >= range.min && x <= range.max) return;
    fail_expected("a number" +
                  within(digits(range.min), digits(range.max), range.min > kAny.min, range.max < kAny.max));
  }
  void whole(std::int64_t& x, Whole range) override {
    boost::system::error_code inexact;
    x = value().is_double() ? range.min : value().to_number<std::int64_t>(inexact);
    if (!value().is_double() && !inexact && x >= range.min && x <= range.max) return;
    constexpr Whole kEvery;
    if (range.min == range.max) fail_expected(std::to_string(range.min));
    fail_expected("a whole number" + within(std::to_string(range.min), std::to_string(range.max),
                                            range.min > kEvery.min, range.max < kEvery.max));
  }
  void seed(std::uint64_t& x) override {
    if (value().is_uint64()) {
      x = value().get_uint64();
      return;
    }
    std::int64_t number = 0;
    whole(number, {0, std::numeric_limits<std::int64_t>::max()});
    x = static_cast<std::uint64_t>(number);
  }
  void boolean(bool& x) override {
    if (!value().is_bool()) fail_expected("true or false");
    x = value().get_bool();
  }
  void text(std::string& x, bool) override {
    if (!value().is_string()) fail_expected("a text");
    x.assign(value().get_string().data(), value().get_string().size());
  }
  void file(std::filesystem::path& x) override {
    std::string name;
    text(name, false);
    x = name;
  }
  void json(json::value& x) override { x = value(); }
  void json(json::object& x) override {
    if (!value().is_object()) fail_expected("an object");
    x = value().get_object();
  }
  bool null_element(bool) override { return value().is_null(); }
  void write_word(std::string_view) override { std::abort(); }
  std::string read_word(const std::vector<std::string_view>& words) override {
    std::string word;
    text(word, false);
    if (std::ranges::find(words, word) != words.end()) return word;
    std::string all;
    for (const std::string_view known : words) all += (all.empty() ? "" : ", ") + std::string(known);
    fail("expected one of " + all + ", found " + control::json_excerpt(value()) + renamed(word, words));
  }

  const json::value& value() const { return *path_.back().value; }
  const json::value* find(std::string_view key) const { return value().get_object().if_contains(view(key)); }

  static std::string below(const std::string& place, std::string_view key) {
    return place + (place.empty() ? "" : ".") + std::string{key};
  }
  std::string where() const {
    std::string place = path_.front().key;
    for (auto step = path_.begin() + 1; step != path_.end(); ++step)
      place = step->key.empty() ? place + "[" + std::to_string(step->element) + "]" : below(place, step->key);
    return place;
  }
  [[noreturn]] static void fail_in(const std::string& place, const std::string& what) {
    throw RecordError(place, what);
  }
  [[noreturn]] void fail_expected(const std::string& what) const {
    fail("expected " + what + ", found " + control::json_excerpt(value()));
  }

  std::vector<Step> path_;
  bool refuses_others_;
};

}  // namespace

bool is_finite(const json::value& value) {
  if (const auto* object = value.if_object())
    return std::ranges::all_of(*object, [](const auto& member) { return is_finite(member.value()); });
  if (const auto* array = value.if_array()) return std::ranges::all_of(*array, is_finite);
  return !value.is_double() || std::isfinite(value.get_double());
}

json::value written_json(const std::function<void(Io&)>& write) {
  JsonWriter io;
  write(io);
  return std::move(io.document);
}

std::expected<void, ReadFault> read_json(const json::value& document, const std::string& name, Others others,
                                         const std::function<void(Io&)>& read) try {
  JsonReader io{document, name, others};
  read(io);
  return {};
} catch (const RecordError& error) {
  return std::unexpected{ReadFault{error.place, error.what()}};
}

}  // namespace truepose::record
