#include "config/text_file.hpp"

#include <cerrno>
#include <cstring>
#include <iterator>

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

std::string read_bytes(const std::filesystem::path& file) {
  std::ifstream in = open_to_read(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) throw ConfigError(file.string() + ": cannot be read: " + std::strerror(errno));
  return text;
}

std::string read_text_file(const std::filesystem::path& file) {
  std::string text = read_bytes(file);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  errno = 0;
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out) throw ConfigError(file.string() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace truepose::config
