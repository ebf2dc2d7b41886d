#include "config/yaml_reader.hpp"

#include <algorithm>
#include <charconv>
#include <unordered_map>

#include "config/number_text.hpp"
#include "config/suggestion.hpp"
#include "config/text_file.hpp"
#include "config/yaml_tree.hpp"

namespace truepose::config {

namespace {

std::string place(const std::string& file, int line, int column) {
  return file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": ";
}

std::string expected_range(const std::string& min, const std::string& max) {
  return "expected " + min + ".." + max;
}

bool is_integer(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

/// Turns the tree of a text into values that stand alone.
class YamlWalk {
 public:
  explicit YamlWalk(const std::string& file_name) : file_(std::make_shared<const std::string>(file_name)) {}

  YamlValue value(const YamlNode& node, const YAML::Mark& mark, std::string path, int depth) {
    // An alias stands for a whole tree and may even contain itself.
    if (depth > kDeepest || ++count_ > kMost)
      throw ConfigError(yaml_place(*file_, mark) + "too many or too deeply nested values");
    YamlValue result;
    result.file_ = file_;
    result.path_ = std::move(path);
    result.line_ = mark.line + 1;
    result.column_ = mark.column + 1;
    switch (node.kind) {
      case YamlNode::Kind::Nothing:
        break;
      case YamlNode::Kind::Scalar:
        result.kind_ = YamlValue::Kind::Scalar;
        result.text_ = node.text;
        result.quoted_ = node.quoted;
        break;
      case YamlNode::Kind::List:
        result.kind_ = YamlValue::Kind::List;
        for (const YamlNode* child : node.children) {
          const std::string item = result.path_ + "[" + std::to_string(result.values_.size() + 1) + "]";
          result.values_.push_back(value(*child, child->mark, item, depth + 1));
        }
        break;
      case YamlNode::Kind::Map:
        result.kind_ = YamlValue::Kind::Map;
        add_entries(result, node.children, depth);
        break;
    }
    return result;
  }

 private:
  static constexpr int kDeepest = 20;
  static constexpr int kMost = 100'000;

  void add_entries(YamlValue& map, const std::vector<const YamlNode*>& children, int depth) {
    std::unordered_map<std::string_view, int> lines;  // of the keys that came before
    for (std::size_t i = 0; i + 1 < children.size(); i += 2) {
      const YamlNode& key = *children[i];
      const YamlNode& node = *children[i + 1];
      if (key.kind != YamlNode::Kind::Scalar)
        throw ConfigError(yaml_place(*file_, key.mark) + "expected a plain name as key");
      const std::string path = (map.path_.empty() ? "" : map.path_ + ".") + shortened(key.text);
      if (const auto [first, is_new] = lines.emplace(key.text, key.mark.line + 1); !is_new) {
        throw ConfigError(yaml_place(*file_, key.mark) + path + ": duplicate key, first given in line " +
                          std::to_string(first->second));
      }
      // The library gives an absent value the place of whatever comes next.
      const bool is_absent = node.kind == YamlNode::Kind::Nothing;
      YamlValue entry = value(node, is_absent ? key.mark : node.mark, path, depth + 1);
      entry.key_line_ = key.mark.line + 1;
      entry.key_column_ = key.mark.column + 1;
      map.keys_.push_back(key.text);
      map.values_.push_back(std::move(entry));
    }
  }

  /// A key as part of the path of all that is below it.
  static std::string shortened(const std::string& key) {
    constexpr std::size_t kLongest = 60;
    return key.size() > kLongest ? key.substr(0, kLongest) + "..." : key;
  }

  std::shared_ptr<const std::string> file_;
  int count_ = 0;
};

void YamlValue::fail(std::string_view what) const {
  const std::string path = path_.empty() ? "" : path_ + ": ";
  throw ConfigError(place(*file_, line_, column_) + path + std::string(what));
}

std::string YamlValue::described() const {
  switch (kind_) {
    case Kind::Nothing:
      return "nothing";
    case Kind::Scalar:
      return in_quotes(text_);
    case Kind::List:
      return "a list";
    case Kind::Map:
      return "a map";
  }
  return {};
}

const std::string& YamlValue::text() const {
  if (text_or_empty().empty()) fail("expected a text, found " + described());
  return text_;
}

const std::string& YamlValue::text_or_empty() const {
  if (kind_ != Kind::Scalar) fail("expected a text, found " + described());
  return text_;
}

const std::string& YamlValue::plain(std::string_view expected) const {
  if (kind_ != Kind::Scalar) fail(std::string(expected) + ", found " + described());
  if (quoted_) fail(std::string(expected) + ", found the text " + described());
  return text_;
}

double YamlValue::number(Range range) const {
  const auto value = parse_number(plain("expected a number"));
  if (!value) fail("expected a number, found " + value.error());
  if (*value < range.min || *value > range.max) {
    fail(expected_range(format_number(range.min), format_number(range.max)) + ", found " + text_);
  }
  return *value;
}

std::int64_t YamlValue::integer(std::int64_t min, std::int64_t max) const {
  const std::string& digits = plain("expected a whole number");
  if (const auto number = parse_number(digits); !number)
    fail("expected a whole number, found " + number.error());
  if (!is_integer(digits)) fail("expected a whole number, found " + digits);
  std::int64_t value = 0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ec != std::errc() || value < min || value > max) {
    fail(expected_range(std::to_string(min), std::to_string(max)) + ", found " + digits);
  }
  return value;
}

std::uint64_t YamlValue::seed() const {
  const std::string& digits = plain("expected a whole number");
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    fail("expected a whole number from 0 to 2^64 - 1, found " + in_quotes(digits));
  }
  return value;
}

bool YamlValue::boolean() const {
  const std::string& word = plain("expected true or false");
  if (word != "true" && word != "false") fail("expected true or false, found " + described());
  return word == "true";
}

std::filesystem::path YamlValue::path_from(const std::filesystem::path& folder) const {
  return (folder / text()).lexically_normal();
}

const std::vector<YamlValue>& YamlValue::list() const {
  if (kind_ != Kind::List) fail("expected a list, found " + described());
  return values_;
}

std::map<std::string, double> YamlValue::numbers(Range range) const {
  if (kind_ != Kind::Map) fail("expected a map of numbers, found " + described());
  std::map<std::string, double> numbers;
  for (std::size_t i = 0; i < keys_.size(); ++i) numbers.emplace(keys_[i], values_[i].number(range));
  return numbers;
}

YamlMap::YamlMap(const YamlValue& value, std::initializer_list<std::string_view> known) : value_(value) {
  if (value.kind_ != YamlValue::Kind::Map) value.fail("expected a map of keys, found " + value.described());
  for (std::size_t i = 0; i < value.keys_.size(); ++i) {
    const std::string& key = value.keys_[i];
    if (std::ranges::find(known, key) != known.end()) continue;
    const std::vector<std::string> names(known.begin(), known.end());
    const YamlValue& entry = value.values_[i];
    throw ConfigError(place(*entry.file_, entry.key_line_, entry.key_column_) + entry.path_ +
                      ": unknown key" + suggestion(key, names));
  }
}

const YamlValue* YamlMap::find(std::string_view key) const {
  const auto found = std::ranges::find(value_.keys_, key);
  if (found == value_.keys_.end()) return nullptr;
  return &value_.values_[static_cast<std::size_t>(found - value_.keys_.begin())];
}

const YamlValue& YamlMap::at(std::string_view key) const {
  if (const YamlValue* value = find(key)) return *value;
  value_.fail("missing key '" + std::string(key) + "'");
}

void YamlMap::read(std::string_view key, double& target, Range range) const {
  if (const YamlValue* value = find(key)) target = value->number(range);
}

void YamlMap::read(std::string_view key, int& target, int min, int max) const {
  if (const YamlValue* value = find(key)) target = static_cast<int>(value->integer(min, max));
}

void YamlMap::read(std::string_view key, bool& target) const {
  if (const YamlValue* value = find(key)) target = value->boolean();
}

void YamlMap::read(std::string_view key, std::string& target) const {
  if (const YamlValue* value = find(key)) target = value->text();
}

void YamlMap::read(std::string_view key, std::chrono::milliseconds& target, int min_ms, int max_ms) const {
  if (const YamlValue* value = find(key)) target = std::chrono::milliseconds(value->integer(min_ms, max_ms));
}

std::optional<std::string_view> YamlMap::choice(std::string_view key,
                                                const std::vector<std::string_view>& words) const {
  const YamlValue* value = find(key);
  if (!value) return std::nullopt;
  const auto found = std::ranges::find(words, value->text());
  if (found != words.end()) return *found;
  std::string all;
  for (const std::string_view word : words) all += (all.empty() ? "" : ", ") + std::string(word);
  value->fail("expected one of " + all + ", found " + in_quotes(value->text()));
}

YamlValue parse_yaml(const std::string& text, const std::string& file_name) {
  const YamlTree tree(text, file_name);
  return YamlWalk(file_name).value(tree.root(), tree.root().mark, "", 0);
}

YamlValue read_yaml(const std::filesystem::path& file) {
  return parse_yaml(read_text_file(file, kMostBytesOfYaml), file.string());
}

}  // namespace truepose::config
