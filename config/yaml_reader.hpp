#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/text_file.hpp"
#include "proto/record/layout.hpp"

namespace truepose::config {

using record::Range, record::Whole;

struct YamlPlace {
  int line = 1, column = 1;  ///< from 1, bytes
};

/// A value of a YAML file that knows where it stands. Every error is a ConfigError "file:line:column: path:
/// what".
///
/// The library only parses: what it makes of a document accepts duplicate keys, reads 010 as 8 and .nan as a
/// number.
class YamlValue {
 public:
  double number(Range range) const;
  std::int64_t integer(std::int64_t min, std::int64_t max) const;
  std::uint64_t seed() const;  ///< any unsigned 64-bit integer
  bool boolean() const;
  /// A scalar as it is written. Not empty.
  const std::string& text() const;
  /// A scalar that may be "".
  const std::string& text_or_empty() const;
  /// One of a few words.
  std::string_view word(const std::vector<std::string_view>& words) const;
  /// A file's path; a relative one starts at the folder of the file that names it.
  std::filesystem::path file() const;
  const std::vector<YamlValue>& list() const;
  /// Of a map of any names: its keys in the file's order, and their values.
  const std::vector<std::string>& keys() const;
  const std::vector<YamlValue>& values() const { return values_; }
  /// Refuses what is no map, or has a key that is not among these: a slip of the finger is never a default.
  void expect_keys(const std::vector<std::string>& known) const;
  /// The member of a map, null where there is none.
  const YamlValue* find(std::string_view key) const;
  /// The member of a map that must be there.
  const YamlValue& at(std::string_view key) const;
  bool is_list() const { return kind_ == Kind::List; }
  bool is_text() const { return kind_ == Kind::Scalar; }

  [[noreturn]] void fail(std::string_view what) const;
  /// "file:line:column: path", as errors begin.
  std::string where() const;
  YamlPlace place() const { return {line_, column_}; }
  YamlPlace key_place() const { return {key_line_, key_column_}; }  ///< of the key before it, in a map

 private:
  friend class YamlWalk;
  enum class Kind { Nothing, Scalar, List, Map };

  std::string described() const;
  /// Its text where it is an unquoted scalar: "7" in quotes is a text and no number.
  const std::string& plain(std::string_view expected) const;

  Kind kind_ = Kind::Nothing;
  std::shared_ptr<const std::string> file_;
  std::string path_;
  int line_ = 1, column_ = 1;
  int key_line_ = 1, key_column_ = 1;  // of the key before it, in a map
  std::string text_;
  bool quoted_ = false;
  std::vector<std::string> keys_;  // of a map, in the file's order
  std::vector<YamlValue> values_;  // of a map or a list
};

/// More values than any file of ours has, an alias counted once.
inline constexpr std::size_t kMostNodesOfYaml = 200'000;
inline constexpr std::size_t kMostBytesOfYaml = std::size_t{16} << 20;

/// Parses one YAML document, in time and memory in proportion to it. `file_name` stands in the messages.
YamlValue parse_yaml(const std::string& text, const std::string& file_name);
YamlValue read_yaml(const std::filesystem::path& file);

}  // namespace truepose::config
