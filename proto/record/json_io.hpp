#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <expected>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/record/io.hpp"

namespace truepose::record {

/// Whether JSON has a word for every number in it.
bool is_finite(const boost::json::value& value);

boost::json::value written_json(const std::function<void(Io&)>& write);
/// What becomes of members that the layout does not know.
enum class Others {
  Passed,   ///< newer versions may write more
  Refused,  ///< parameters: one that is misspelt must not be taken for left out
};
struct ReadFault {
  std::string place;  ///< "points[3].pose"
  std::string text;   ///< "points[3].pose: expected a whole number of 1 or more"
};
/// @param name  how errors call the whole; empty: only by what is in it
std::expected<void, ReadFault> read_json(const boost::json::value& document, const std::string& name,
                                         Others others, const std::function<void(Io&)>& read);

template <class Record>
boost::json::value value_json(const Record& x) {
  // A layout changes a record only where it reads.
  return written_json([&](Io& io) { io.value(const_cast<Record&>(x)); });
}

template <class Record>
boost::json::object to_json(const Record& x) {
  return std::move(value_json(x).as_object());
}

template <class Record>
boost::json::array to_json(const std::vector<Record>& list) {
  return std::move(value_json(list).as_array());
}

template <class Record>
std::expected<Record, std::string> from_json(const boost::json::value& document,
                                             const std::string& name = "") {
  Record x;
  const auto read = read_json(document, name, Others::Passed, [&](Io& io) { io.value(x); });
  if (!read) return std::unexpected(read.error().text);
  return x;
}

}  // namespace truepose::record
