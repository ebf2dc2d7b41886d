#include "config/yaml_reader.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <charconv>
#include <deque>
#include <sstream>
#include <unordered_map>

#include "config/number_text.hpp"
#include "core/formatted.hpp"
#include "proto/text/renamed.hpp"
#include "proto/text/utf8.hpp"

namespace truepose::config {

namespace {

std::string place_text(const std::string& file, int line, int column) {
  return file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": ";
}

std::string yaml_place(const std::string& file, const YAML::Mark& mark) {
  return place_text(file, mark.line + 1, mark.column + 1);
}

std::string expected_range(const std::string& min, const std::string& max) {
  return "expected " + min + ".." + max;
}

bool is_integer(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// One value of a YAML text as the library's parser tells it. An alias is the very node that it stands for,
/// so a tree may contain itself.
struct YamlNode {
  enum class Kind { Nothing, Scalar, List, Map };

  Kind kind = Kind::Nothing;
  YAML::Mark mark;
  std::string text;                       ///< of a scalar
  bool quoted = false;                    ///< a scalar in quotes or with a tag
  std::vector<const YamlNode*> children;  ///< of a list; of a map: key, value, key, value ...
};

/// The nodes of a text that is one YAML document; the first is its root. The library's own loader never ends
/// where a comma stands in place of a value, and its tree takes many times the memory.
class YamlTree {
 public:
  /// Throws ConfigError. @param file_name  stands in the messages
  YamlTree(const std::string& text, const std::string& file_name);

  const YamlNode& root() const { return nodes_.front(); }

 private:
  class Builder;

  std::deque<YamlNode> nodes_;
};

/// Makes nodes of the parser's events.
class YamlTree::Builder : public YAML::EventHandler {
 public:
  Builder(std::deque<YamlNode>& nodes, const std::string& text, const std::string& file)
      : nodes_(nodes), text_(text), file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    // The parser leaves a comma where it stands and continues with a next document, for ever.
    const auto position = static_cast<std::size_t>(mark.pos);
    if (open_.empty() && position < text_.size() && text_[position] == ',')
      throw ConfigError(yaml_place(file_, mark) + "not valid YAML: a comma in place of a value");
    add(YamlNode::Kind::Nothing, mark, anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    expect_utf8(value, mark);
    YamlNode& node = add(YamlNode::Kind::Scalar, mark, anchor);
    node.text = value;
    node.quoted = tag != "?";
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open_.push_back(&add(YamlNode::Kind::List, mark, anchor));
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open_.push_back(&add(YamlNode::Kind::Map, mark, anchor));
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapEnd() override { open_.pop_back(); }
  void OnAlias(const YAML::Mark&, YAML::anchor_t anchor) override { attach(*anchored_.at(anchor)); }

 private:
  /// Clients get these values as JSON, which holds nothing but UTF-8.
  void expect_utf8(std::string_view value, const YAML::Mark& mark) const {
    while (!value.empty()) {
      const std::string_view here = value;
      const bool replaced = text::take_code_point(value) == text::kReplacement;
      if (replaced && here.size() - value.size() == 1)
        throw ConfigError(yaml_place(file_, mark) +
                          formatted("byte 0x%02X in this text is not UTF-8: save the file in UTF-8",
                                    static_cast<unsigned>(static_cast<unsigned char>(here.front()))));
    }
  }

  YamlNode& add(YamlNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (open_.empty() && !nodes_.empty())
      throw ConfigError(yaml_place(file_, mark) + "a second document, expected one");
    if (nodes_.size() == kMostNodesOfYaml)
      throw ConfigError(yaml_place(file_, mark) + "too many or too deeply nested values");
    YamlNode& node = nodes_.emplace_back();
    node.kind = kind;
    node.mark = mark;
    // The parser counts anchors from 1.
    if (anchored_.size() <= anchor) anchored_.resize(anchor + 1, nullptr);
    anchored_[anchor] = &node;
    attach(node);
    return node;
  }

  void attach(const YamlNode& node) {
    if (!open_.empty()) open_.back()->children.push_back(&node);
  }

  std::deque<YamlNode>& nodes_;
  const std::string& text_;
  const std::string& file_;
  std::vector<YamlNode*> open_;
  std::vector<const YamlNode*> anchored_;
};

YamlTree::YamlTree(const std::string& text, const std::string& file_name) {
  std::istringstream in(text);
  try {
    YAML::Parser parser(in);
    Builder builder(nodes_, text, file_name);
    if (!parser.HandleNextDocument(builder) || nodes_.empty())
      throw ConfigError(file_name + ":1:1: the file is empty");
    parser.HandleNextDocument(builder);
  } catch (const YAML::Exception& error) {
    throw ConfigError(yaml_place(file_name, error.mark) + "not valid YAML: " + error.msg);
  }
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
  throw ConfigError(place_text(*file_, line_, column_) + path + std::string(what));
}

std::string YamlValue::where() const {
  const std::string where = place_text(*file_, line_, column_) + path_;
  return path_.empty() ? where.substr(0, where.size() - 2) : where;
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

std::string_view YamlValue::word(const std::vector<std::string_view>& words) const {
  const auto found = std::ranges::find(words, text());
  if (found != words.end()) return *found;
  std::string all;
  for (const std::string_view word : words) all += (all.empty() ? "" : ", ") + std::string(word);
  fail("expected one of " + all + ", found " + in_quotes(text()) + renamed(text(), words));
}

std::filesystem::path YamlValue::file() const {
  return (std::filesystem::path(*file_).parent_path() / text()).lexically_normal();
}

const std::vector<YamlValue>& YamlValue::list() const {
  if (kind_ != Kind::List) fail("expected a list, found " + described());
  return values_;
}

const std::vector<std::string>& YamlValue::keys() const {
  if (kind_ != Kind::Map) fail("expected a map of numbers, found " + described());
  return keys_;
}

void YamlValue::expect_keys(const std::vector<std::string>& known) const {
  if (kind_ != Kind::Map) fail("expected a map of keys, found " + described());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::string& key = keys_[i];
    if (std::ranges::find(known, key) != known.end()) continue;
    const YamlValue& entry = values_[i];
    throw ConfigError(place_text(*entry.file_, entry.key_line_, entry.key_column_) + entry.path_ +
                      ": unknown key" + suggestion(key, known));
  }
}

const YamlValue* YamlValue::find(std::string_view key) const {
  const auto found = std::ranges::find(keys_, key);
  return found == keys_.end() ? nullptr : &values_[static_cast<std::size_t>(found - keys_.begin())];
}

const YamlValue& YamlValue::at(std::string_view key) const {
  if (const YamlValue* value = find(key)) return *value;
  fail("missing key '" + std::string(key) + "'");
}

YamlValue parse_yaml(const std::string& text, const std::string& file_name) {
  const YamlTree tree(text, file_name);
  return YamlWalk(file_name).value(tree.root(), tree.root().mark, "", 0);
}

YamlValue read_yaml(const std::filesystem::path& file) {
  return parse_yaml(read_text_file(file, kMostBytesOfYaml), file.string());
}

}  // namespace truepose::config
