#include "config/import/xacro_file.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "config/import/xacro_expression.hpp"
#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::config {
namespace {

namespace fs = std::filesystem;
using pugi::xml_node;

constexpr std::string_view kPrefix = "xacro:";
constexpr std::size_t kMostBytesOfXml = std::size_t{16} << 20;
constexpr int kMostNodes = 200'000, kMostNesting = 60;

/// A file that was read, which lives as long as its macros.
struct SourceFile {
  fs::path path;
  std::string text;
  pugi::xml_document document;
};

/// A parameter of a macro.
struct Parameter {
  enum class Kind { Value, Block, Children };
  Kind kind = Kind::Value;
  std::string name;
  std::optional<std::string> standard;  ///< default as written
  bool takes_outer = false;             ///< "^": what the caller's scope has
};

struct Macro {
  const SourceFile* file = nullptr;
  xml_node body;
  std::vector<Parameter> parameters;
};

/// An element that a call hands to a macro, with the scope that it is expanded in.
struct Scope;
struct Block {
  const SourceFile* file = nullptr;
  xml_node node;
  Scope* scope = nullptr;
  bool children_only = false;
};

struct Scope {
  Scope* outer = nullptr;
  std::map<std::string, std::string> properties;  ///< values as written; evaluated where they are used
  std::map<std::string, Block> blocks;
};

/// Says nothing about where a joint stands.
bool is_left_out(std::string_view name, bool keeps_masses) {
  constexpr std::array<std::string_view, 13> kLeftOut{"visual",
                                                      "collision",
                                                      "material",
                                                      "gazebo",
                                                      "transmission",
                                                      "ros2_control",
                                                      "sensor",
                                                      "dynamics",
                                                      "safety_controller",
                                                      "calibration",
                                                      "inertia",
                                                      "hardware_interface",
                                                      "disable_collisions"};
  return std::ranges::find(kLeftOut, name) != kLeftOut.end() || (name == "inertial" && !keeps_masses);
}

/// "prefix name:=x *origin" by its words; quotes hold blanks together.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  std::string word;
  char quote = 0;
  for (const char c : text) {
    if (quote == 0 && xml::is_space(c)) {
      if (!word.empty()) words.push_back(std::exchange(word, {}));
      continue;
    }
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    }
    word += c;
  }
  if (!word.empty()) words.push_back(word);
  return words;
}

std::string without_quotes(const std::string& text) {
  if (text.size() < 2 || text.front() != text.back() || (text.front() != '\'' && text.front() != '"'))
    return text;
  return text.substr(1, text.size() - 2);
}

Parameter parameter_of(const std::string& word) {
  Parameter parameter;
  const std::size_t equals = word.find('=');
  std::string name = word.substr(0, equals);
  if (equals != std::string::npos) {
    if (name.ends_with(':')) name.pop_back();
    std::string standard = word.substr(equals + 1);
    if (standard.starts_with('^')) {
      parameter.takes_outer = true;
      standard.erase(0, standard.starts_with("^|") ? 2 : 1);
      if (!standard.empty() || word.ends_with('|')) parameter.standard = without_quotes(standard);
    } else {
      parameter.standard = without_quotes(standard);
    }
  }
  if (name.starts_with("**")) {
    parameter.kind = Parameter::Kind::Children;
    name.erase(0, 2);
  } else if (name.starts_with('*')) {
    parameter.kind = Parameter::Kind::Block;
    name.erase(0, 1);
  }
  parameter.name = name;
  return parameter;
}

class Expander {
 public:
  explicit Expander(const XacroOptions& options) : options_{options} {}

  pugi::xml_document expanded(const fs::path& file) {
    const SourceFile& source = read(file);
    pugi::xml_document result;
    const xml_node robot = source.document.document_element();
    xml_node out = result.append_child("robot");
    Scope scope;
    if (const auto name = robot.attribute("name"))
      out.append_attribute("name") = substituted(source, robot, name.value(), scope).c_str();
    expand_children(source, robot, out, scope);
    return result;
  }

 private:
  [[noreturn]] void fail(const SourceFile& file, xml_node node, const std::string& what) const {
    std::string hint;
    if (!missing_.empty()) hint = " (not found: " + missing_.front() + ")";
    throw ConfigError{place(file, node) + ": <" + node.name() + ">: " + what + hint};
  }
  static std::string place(const SourceFile& file, xml_node node) {
    const auto offset = static_cast<std::ptrdiff_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
    const auto end = file.text.begin() + std::min<std::ptrdiff_t>(offset, std::ssize(file.text));
    return file.path.string() + ":" + std::to_string(1 + std::count(file.text.begin(), end, '\n'));
  }

  const SourceFile& read(const fs::path& path) {
    SourceFile& file = files_.emplace_back();
    file.path = path;
    file.text = read_text_file(path, kMostBytesOfXml);
    const pugi::xml_parse_result parsed = file.document.load_buffer(file.text.data(), file.text.size());
    if (!parsed) {
      const auto end = file.text.begin() + std::min(parsed.offset, std::ssize(file.text));
      throw ConfigError{path.string() + ":" + std::to_string(1 + std::count(file.text.begin(), end, '\n')) +
                        ": no XML: " + parsed.description()};
    }
    const std::string_view root = file.document.document_element().name();
    if (root != "robot")
      throw ConfigError{path.string() + ": the root is <" + std::string{root} +
                        ">, expected <robot> of a URDF or xacro"};
    return file;
  }

  std::optional<std::string> property(const std::string& name, const Scope& scope) const {
    for (const Scope* each = &scope; each != nullptr; each = each->outer)
      if (const auto found = each->properties.find(name); found != each->properties.end())
        return found->second;
    return std::nullopt;
  }

  /// A text with its ${...} and $(...) replaced.
  std::string substituted(const SourceFile& file, xml_node node, std::string_view text, const Scope& scope) {
    if (++nesting_ > kMostNesting) fail(file, node, "is nested too deeply, or a property names itself");
    std::string result;
    while (!text.empty()) {
      const std::size_t dollar = text.find('$');
      result += text.substr(0, dollar);
      if (dollar == std::string_view::npos) break;
      text.remove_prefix(dollar);
      const char open = text.size() > 1 ? text[1] : '\0';
      if (text.starts_with("$$")) {
        result += '$';
        text.remove_prefix(2);
      } else if (open == '{' || open == '(') {
        const std::size_t end = text.find(open == '{' ? '}' : ')');
        if (end == std::string_view::npos) fail(file, node, "no end of " + in_quotes(text));
        const std::string inside{text.substr(2, end - 2)};
        result += open == '{' ? xacro_text(evaluated(file, node, inside, scope))
                              : command(file, node, inside, scope);
        text.remove_prefix(end + 1);
      } else {
        result += '$';
        text.remove_prefix(1);
      }
    }
    --nesting_;
    return result;
  }

  XacroValue evaluated(const SourceFile& file, xml_node node, const std::string& expression,
                       const Scope& scope) {
    const auto value = evaluate_xacro(expression, [&](const std::string& name) -> std::optional<XacroValue> {
      const auto text = property(name, scope);
      if (!text) return std::nullopt;
      return xacro_value(substituted(file, node, *text, scope));
    });
    if (!value) fail(file, node, "${" + expression + "}: " + value.error());
    return *value;
  }

  std::string command(const SourceFile& file, xml_node node, const std::string& inside, const Scope& scope) {
    const std::vector<std::string> words = words_of(inside);
    if (words.size() == 2 && words[0] == "find") return folder_of_package(file, words[1]).string();
    if (words.size() == 2 && words[0] == "arg") {
      const std::string name = substituted(file, node, words[1], scope);
      if (const auto given = options_.arguments.find(name); given != options_.arguments.end())
        return given->second;
      if (const auto standard = arguments_.find(name); standard != arguments_.end()) return standard->second;
      fail(file, node, "the argument " + in_quotes(name) + " has no value. Give --arg " + name + "=VALUE.");
    }
    fail(file, node, "$(" + inside + ") is not understood; only $(find PACKAGE) and $(arg NAME) are");
  }

  /// A package near the file: a folder of that name among those that the file is in, or next to one of
  /// them.
  static fs::path folder_of_package(const SourceFile& file, const std::string& package) {
    for (fs::path folder = fs::absolute(file.path).parent_path(); folder.has_relative_path();
         folder = folder.parent_path()) {
      if (folder.filename() == package) return folder;
      if (fs::is_directory(folder / package)) return folder / package;
    }
    return fs::path{package};
  }

  bool is_met(const SourceFile& file, xml_node node, const Scope& scope) {
    const auto attribute = node.attribute("value");
    if (!attribute) fail(file, node, "has no value");
    const XacroValue value = xacro_value(substituted(file, node, attribute.value(), scope));
    if (const double* number = std::get_if<double>(&value)) return *number != 0;
    fail(file, node, "value: expected true or false, found " + in_quotes(std::get<std::string>(value)));
  }

  void expand_children(const SourceFile& file, xml_node from, xml_node out, Scope& scope) {
    if (++nesting_ > kMostNesting) fail(file, from, "is nested too deeply");
    for (const xml_node child : from.children())
      if (child.type() == pugi::node_element) expand(file, child, out, scope);
    --nesting_;
  }

  void expand(const SourceFile& file, xml_node node, xml_node out, Scope& scope) {
    if (++nodes_ > kMostNodes) fail(file, node, "more than " + std::to_string(kMostNodes) + " elements");
    const std::string_view name = node.name();
    if (is_left_out(name, options_.keeps_masses)) return;
    if (name.starts_with(kPrefix))
      return expand_xacro_element(file, node, std::string{name.substr(kPrefix.size())}, out, scope);
    if (name == "include" || name == "macro" ||
        (name == "property" && node.parent() == file.document.document_element()))
      fail(file, node, "is xacro of an old form. Write it with the prefix xacro:");
    xml_node copy = out.append_child(node.name());
    for (const auto& attribute : node.attributes())
      copy.append_attribute(attribute.name()) = substituted(file, node, attribute.value(), scope).c_str();
    expand_children(file, node, copy, scope);
  }

  void expand_xacro_element(const SourceFile& file, xml_node node, const std::string& name, xml_node out,
                            Scope& scope) {
    if (name == "if" || name == "unless") {
      if (is_met(file, node, scope) == (name == "if")) expand_children(file, node, out, scope);
    } else if (name == "include") {
      include(file, node, out, scope);
    } else if (name == "property") {
      define_property(file, node, scope);
    } else if (name == "arg") {
      const std::string argument = node.attribute("name").value();
      if (const auto standard = node.attribute("default"))
        arguments_.try_emplace(argument, substituted(file, node, standard.value(), scope));
    } else if (name == "macro") {
      Macro macro{&file, node, {}};
      for (const std::string& word : words_of(node.attribute("params").value()))
        macro.parameters.push_back(parameter_of(word));
      std::string macro_name = node.attribute("name").value();
      if (macro_name.starts_with(kPrefix)) macro_name.erase(0, kPrefix.size());
      macros_.insert_or_assign(macro_name, std::move(macro));
    } else if (name == "insert_block") {
      insert_block(file, node, out, scope);
    } else {
      call(file, node, name, out, scope);
    }
  }

  void define_property(const SourceFile& file, xml_node node, Scope& scope) {
    const std::string name = node.attribute("name").value();
    if (name.empty()) fail(file, node, "has no name");
    const std::string_view where = node.attribute("scope").value();
    Scope* target = &scope;
    if (where == "parent" && scope.outer) target = scope.outer;
    while (where == "global" && target->outer) target = target->outer;
    if (const auto standard = node.attribute("default"); standard && !node.attribute("value")) {
      if (!property(name, scope)) target->properties.insert_or_assign(name, standard.value());
    } else if (const auto value = node.attribute("value")) {
      target->properties.insert_or_assign(name, value.value());
    } else {
      scope.blocks.insert_or_assign(name, Block{&file, node, &scope, true});
    }
  }

  void include(const SourceFile& file, xml_node node, xml_node out, Scope& scope) {
    fs::path path = substituted(file, node, node.attribute("filename").value(), scope);
    if (path.empty()) fail(file, node, "has no filename");
    if (path.is_relative() && !fs::exists(path)) path = folder_of(file.path) / path;
    if (!fs::exists(path)) {
      // Most hold only colours. Whatever needs one that is not there names it.
      missing_.push_back(path.string() + ", included at " + place(file, node));
      return;
    }
    if (std::ranges::count(files_, path, &SourceFile::path) > 20) fail(file, node, "includes itself");
    const SourceFile& included = read(path);
    expand_children(included, included.document.document_element(), out, scope);
  }

  void insert_block(const SourceFile& file, xml_node node, xml_node out, Scope& scope) {
    const std::string name = substituted(file, node, node.attribute("name").value(), scope);
    for (Scope* each = &scope; each != nullptr; each = each->outer) {
      const auto found = each->blocks.find(name);
      if (found == each->blocks.end()) continue;
      const Block block = found->second;
      if (block.children_only) {
        expand_children(*block.file, block.node, out, *block.scope);
      } else if (block.node) {
        expand(*block.file, block.node, out, *block.scope);
      }
      return;
    }
    fail(file, node, "the block " + in_quotes(name) + " is not defined");
  }

  void call(const SourceFile& file, xml_node node, const std::string& name, xml_node out, Scope& scope) {
    const auto found = macros_.find(name);
    if (found == macros_.end())
      fail(file, node, "no macro of this name is defined, and it is no part of xacro that is understood");
    const Macro macro = found->second;
    Scope inner;
    inner.outer = &scope;
    xml_node block = node.first_child();
    for (const Parameter& parameter : macro.parameters) {
      if (parameter.kind == Parameter::Kind::Value) {
        inner.properties.insert_or_assign(parameter.name, argument(file, node, parameter, scope));
        continue;
      }
      while (block && block.type() != pugi::node_element) block = block.next_sibling();
      if (!block && !parameter.standard)
        fail(file, node, "the block " + in_quotes(parameter.name) + " is missing");
      inner.blocks.insert_or_assign(parameter.name,
                                    Block{&file, block, &scope, parameter.kind == Parameter::Kind::Children});
      if (block) block = block.next_sibling();
    }
    for (const auto& attribute : node.attributes()) {
      const std::string_view given = attribute.name();
      if (!given.starts_with("xmlns") &&
          std::ranges::find(macro.parameters, given, &Parameter::name) == macro.parameters.end())
        fail(file, node, "the macro has no parameter " + in_quotes(given));
    }
    expand_children(*macro.file, macro.body, out, inner);
  }

  std::string argument(const SourceFile& file, xml_node node, const Parameter& parameter,
                       const Scope& scope) {
    if (const auto given = node.attribute(parameter.name.c_str()))
      return substituted(file, node, given.value(), scope);
    if (parameter.takes_outer) {
      if (const auto outer = property(parameter.name, scope)) return substituted(file, node, *outer, scope);
    }
    if (parameter.standard) return substituted(file, node, *parameter.standard, scope);
    fail(file, node, "the parameter " + in_quotes(parameter.name) + " is missing");
  }

  const XacroOptions& options_;
  std::deque<SourceFile> files_;
  std::map<std::string, Macro> macros_;
  std::map<std::string, std::string> arguments_;  // of xacro:arg, their defaults
  std::vector<std::string> missing_;              // includes that were not found
  int nesting_ = 0, nodes_ = 0;
};

}  // namespace

pugi::xml_document expand_xacro(const fs::path& file, const XacroOptions& options) {
  return Expander{options}.expanded(file);
}

}  // namespace truepose::config
