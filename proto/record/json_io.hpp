#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <expected>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/record/layout.hpp"

namespace truepose::record {

/// What WriteIo makes of a record in JSON.
struct JsonText {
  using Value = boost::json::value;

  static Value number(double number) { return number; }
  static Value whole(std::int64_t number) { return number; }
  static Value seed(std::uint64_t number) { return number; }
  static Value boolean(bool flag) { return flag; }
  static Value text(std::string_view text) {
    return Value(boost::json::string_view{text.data(), text.size()});
  }
  static Value word(std::string_view word) { return text(word); }
  static Value list(std::vector<Value> elements) {
    return boost::json::array(std::make_move_iterator(elements.begin()),
                              std::make_move_iterator(elements.end()));
  }
  static Value record(std::vector<std::pair<std::string, Value>> members);
};

/// A value of a JSON document that knows the path to it. Every error is a RecordError "points[3].pose: what".
class JsonPlace {
 public:
  class Map;

  JsonPlace(const boost::json::value& value, std::string path) : value_{&value}, path_{std::move(path)} {}

  double number(Range range) const;
  std::int64_t integer(std::int64_t min, std::int64_t max) const;
  std::uint64_t seed() const;
  bool boolean() const;
  std::string text() const;
  std::string text_or_empty() const { return text(); }
  /// One of a few words.
  std::string word(const std::vector<std::string_view>& words) const;
  std::string file() const { return text(); }
  std::vector<JsonPlace> list() const;
  std::vector<std::pair<std::string, JsonPlace>> members() const;

  [[noreturn]] void fail(const std::string& what) const;

 private:
  [[noreturn]] void fail_expected(const std::string& what) const;

  const boost::json::value* value_;
  std::string path_;
};

/// An object read by name. Keys that are not known are passed over: newer versions may write more.
class JsonPlace::Map {
 public:
  Map(const JsonPlace& place, const std::vector<std::string>& known);

  std::optional<JsonPlace> find(std::string_view key) const;
  JsonPlace at(std::string_view key) const;
  const JsonPlace& value() const { return place_; }

 private:
  JsonPlace place_;
  const boost::json::object* object_;
};

/// A value that is not what a record expects there. what(): "points[3].pose: expected a whole number of 1 or
/// more".
class RecordError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether JSON has a word for every number in it.
bool is_finite(const boost::json::value& value);

template <class Record>
boost::json::object to_json(const Record& x) {
  return std::move(WriteIo<JsonText>::value(x).as_object());
}

template <class Record>
boost::json::array to_json(const std::vector<Record>& list) {
  return std::move(WriteIo<JsonText>::value(list).as_array());
}

/// @param name  how errors call the whole; empty: only by what is in it
template <class Record>
std::expected<Record, std::string> from_json(const boost::json::value& document, std::string name = "") try {
  Record x;
  ReadIo<JsonPlace>::read(JsonPlace{document, std::move(name)}, x);
  return x;
} catch (const RecordError& error) {
  return std::unexpected{error.what()};
}

}  // namespace truepose::record
