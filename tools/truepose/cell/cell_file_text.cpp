#include "tools/truepose/cell/cell_file_text.hpp"

#include "config/text_file.hpp"
#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

std::string with_replaced(const std::filesystem::path& file, const Replacements& replacements) {
  std::string text = config::read_text_file(file);
  for (const auto& [from, to] : replacements) {
    const std::size_t at = text.find(from);
    if (at == text.npos) {
      throw CommandError{kBadInput, file.string() + ": has no '" + std::string{from} +
                                        "'. Use the files that were installed with this program."};
    }
    text.replace(at, from.size(), to);
  }
  return text;
}

}  // namespace truepose::tools
