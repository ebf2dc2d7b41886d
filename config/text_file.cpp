#include "config/text_file.hpp"

#include <array>
#include <cerrno>
#include <cstring>

#include "config/unfinished_file.hpp"

namespace truepose::config {

std::ifstream open_to_read(const std::filesystem::path& file) {
  // A folder opens like a file and only fails to be read.
  if (std::error_code ignored; std::filesystem::is_directory(file, ignored)) {
    throw ConfigError(file.string() + ": is a folder, expected a file");
  }
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ConfigError(file.string() + ": cannot be opened: " + std::strerror(errno));
  return in;
}

std::string read_bytes(const std::filesystem::path& file, std::size_t most) {
  std::ifstream in = open_to_read(file);
  std::string text;
  std::array<char, 64 * 1024> block;
  do {
    in.read(block.data(), block.size());
    text.append(block.data(), static_cast<std::size_t>(in.gcount()));
    if (text.size() > most) {
      throw ConfigError(file.string() + ": has more than " + std::to_string(most >> 20U) +
                        " MiB, the most that is read of such a file");
    }
  } while (in);
  if (in.bad()) throw ConfigError(file.string() + ": cannot be read: " + std::strerror(errno));
  return text;
}

std::string read_text_file(const std::filesystem::path& file, std::size_t most) {
  std::string text = read_bytes(file, most);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  write_together({{file, text}});
}

}  // namespace truepose::config
