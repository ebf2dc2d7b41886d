#include "tools/truepose/written_together.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "config/config_error.hpp"

namespace truepose::tools {

namespace {

std::filesystem::path unfinished(const TextFile& file) {
  return file.path.string() + "." + std::to_string(getpid());
}

void write_unfinished(const TextFile& file) {
  // What would keep a file from its place is found before the first takes its own.
  if (std::error_code ignored; std::filesystem::is_directory(file.path, ignored))
    throw config::ConfigError(file.path.string() + ": is a folder, expected a file");
  errno = 0;
  std::ofstream out(unfinished(file), std::ios::binary | std::ios::trunc);
  out << file.text;
  out.close();
  if (!out) throw config::ConfigError(file.path.string() + ": cannot be written: " + std::strerror(errno));
}

void take_place(const TextFile& file) {
  std::error_code error;
  std::filesystem::rename(unfinished(file), file.path, error);
  if (error) throw config::ConfigError(file.path.string() + ": cannot be written: " + error.message());
}

}  // namespace

void write_together(const std::vector<TextFile>& files) {
  try {
    for (const TextFile& file : files) write_unfinished(file);
    for (const TextFile& file : files) take_place(file);
  } catch (const config::ConfigError&) {
    for (const TextFile& file : files) {
      std::error_code ignored;
      std::filesystem::remove(unfinished(file), ignored);
    }
    throw;
  }
}

}  // namespace truepose::tools
