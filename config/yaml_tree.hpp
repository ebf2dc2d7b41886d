#pragma once

#include <yaml-cpp/mark.h>

#include <deque>
#include <string>
#include <vector>

namespace truepose::config {

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
  static constexpr std::size_t kMostNodes = 200'000;

  /// Throws ConfigError. @param file_name  stands in the messages
  YamlTree(const std::string& text, const std::string& file_name);

  const YamlNode& root() const { return nodes_.front(); }

 private:
  class Builder;

  std::deque<YamlNode> nodes_;
};

/// "cell.yaml:12:3: "
std::string yaml_place(const std::string& file, const YAML::Mark& mark);

}  // namespace truepose::config
