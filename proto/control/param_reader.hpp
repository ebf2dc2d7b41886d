#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "proto/control/request.hpp"

namespace truepose::control {

/// Reads the parameters of one call. Ask for each, then finish(): it reports the first thing that was wrong,
/// an unexpected parameter included. Values read before that are usable only if it reports nothing, so none
/// of these may end without it: what was wrong would be taken for what was left out.
///
///   ParamReader read{params};
///   const auto poses = read.integer("poses", 1, 1000).value_or(30);
///   const auto id = read.required(read.id("id"), "id");
///   if (auto error = read.finish()) return std::unexpected(*error);
class ParamReader {
 public:
  explicit ParamReader(const boost::json::object& params) : params_{params} {}
  ParamReader(const ParamReader&) = delete;
  ParamReader& operator=(const ParamReader&) = delete;
  ~ParamReader() { assert(finished_ || std::uncaught_exceptions() > 0); }

  std::optional<std::int64_t> integer(std::string_view key, std::int64_t min, std::int64_t max);
  /// A finite number within [min, max]; integers count.
  std::optional<double> number(std::string_view key, double min, double max);
  std::optional<bool> boolean(std::string_view key);
  /// At most max_size characters.
  std::optional<std::string> text(std::string_view key, std::size_t max_size = 256);
  /// 1..64 characters: an empty one names nothing, not even what is meant where none is given.
  std::optional<std::string> id(std::string_view key);
  /// A list of distinct strings.
  std::optional<std::vector<std::string>> texts(std::string_view key);
  /// At most max_size integers within [min, max].
  std::optional<std::vector<int>> integers(std::string_view key, int min, int max, std::size_t max_size);
  /// Rows of `columns` finite numbers each, 1..max_rows of them.
  std::optional<std::vector<std::vector<double>>> rows(std::string_view key, std::size_t columns,
                                                       std::size_t max_rows);

  /// Turns an absent parameter into an error; returns the value, or a default one after an error.
  template <typename T>
  T required(std::optional<T> value, std::string_view key) {
    if (!value) fail_missing(key);
    return std::move(value).value_or(T{});
  }

  /// Reports a parameter that reads well but makes no sense: "params.poses: <reason>".
  void fail(std::string_view key, std::string_view reason);

  /// The first error, if any. Ask last.
  std::optional<RpcError> finish();

 private:
  const boost::json::value* find(std::string_view key);
  void expected(std::string_view key, std::string_view what, const boost::json::value& found);
  void fail_missing(std::string_view key);

  const boost::json::object& params_;
  std::set<std::string, std::less<>> known_;
  std::optional<RpcError> error_;
  bool finished_ = false;
};

}  // namespace truepose::control
