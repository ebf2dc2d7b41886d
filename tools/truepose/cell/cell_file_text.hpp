#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose::tools {

/// Texts of a shipped file, and what stands there instead.
using Replacements = std::vector<std::pair<std::string_view, std::string>>;

/// The text of a file with all of them done.
/// Throws ConfigError where the file cannot be read, CommandError (kBadInput) where it lacks one of the
/// texts.
std::string with_replaced(const std::filesystem::path& file, const Replacements& replacements);

}  // namespace truepose::tools
