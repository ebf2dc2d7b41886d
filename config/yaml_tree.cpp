#include "config/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <sstream>

#include "config/config_error.hpp"

namespace truepose::config {

/// Makes nodes of the parser's events.
class YamlTree::Builder : public YAML::EventHandler {
 public:
  Builder(std::deque<YamlNode>& nodes, const std::string& text, const std::string& file)
      : nodes_(nodes), text_(text), file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    // The parser leaves a comma where it stands and goes on with a next document, for ever.
    const auto position = static_cast<std::size_t>(mark.pos);
    if (open_.empty() && position < text_.size() && text_[position] == ',')
      throw ConfigError(yaml_place(file_, mark) + "not valid YAML: a comma in place of a value");
    add(YamlNode::Kind::Nothing, mark, anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
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
  YamlNode& add(YamlNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (open_.empty() && !nodes_.empty())
      throw ConfigError(yaml_place(file_, mark) + "a second document, expected one");
    if (nodes_.size() == kMostNodes)
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

std::string yaml_place(const std::string& file, const YAML::Mark& mark) {
  return file + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1) + ": ";
}

}  // namespace truepose::config
