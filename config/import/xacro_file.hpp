#pragma once

#include <filesystem>
#include <map>
#include <pugixml.hpp>
#include <string>

namespace truepose::config {

struct XacroOptions {
  std::map<std::string, std::string> arguments;  ///< of xacro:arg, in place of their defaults
  bool keeps_masses = false;                     ///< expands <inertial> too
};

/// Expands a xacro or URDF file: properties, arguments, macros with their parameters and blocks, ${...}
/// (evaluate_xacro()), $(arg ..), $(find ..), if, unless and include. What does not say where a joint stands
/// (shapes, materials, gazebo, transmissions, controllers) is left out unread.
///
/// A package of $(find ..) is looked for among and next to the folders that the including file is in.
/// @return <robot> with <link> and <joint>
/// Throws ConfigError with file and line.
pugi::xml_document expand_xacro(const std::filesystem::path& file, const XacroOptions& options);

}  // namespace truepose::config
