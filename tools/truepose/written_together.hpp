#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace truepose::tools {

struct TextFile {
  std::filesystem::path path;
  std::string text;
};

/// Writes files that belong together: none of them appears, or is replaced, before all are written in full
/// beside their places. Throws ConfigError.
void write_together(const std::vector<TextFile>& files);

}  // namespace truepose::tools
