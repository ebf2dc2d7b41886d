#include "tools/truepose/written_together.hpp"

#include <unistd.h>

#include "config/text_file.hpp"

namespace truepose::tools {

namespace {

std::filesystem::path unfinished(const TextFile& file) {
  return file.path.string() + "." + std::to_string(getpid());
}

void remove_unfinished(const std::vector<TextFile>& files) {
  for (const TextFile& file : files) {
    std::error_code ignored;
    std::filesystem::remove(unfinished(file), ignored);
  }
}

}  // namespace

void write_together(const std::vector<TextFile>& files) {
  try {
    for (const TextFile& file : files) {
      // What would keep a file from its place is found before the first takes its own.
      if (std::error_code ignored; std::filesystem::is_directory(file.path, ignored))
        throw config::ConfigError(file.path.string() + ": is a folder, expected a file");
      config::write_text_file(unfinished(file), file.text);
    }
    for (const TextFile& file : files) std::filesystem::rename(unfinished(file), file.path);
  } catch (const std::filesystem::filesystem_error& error) {
    remove_unfinished(files);
    throw config::ConfigError(error.path2().string() + ": cannot be written: " + error.code().message());
  } catch (const config::ConfigError&) {
    remove_unfinished(files);
    throw;
  }
}

}  // namespace truepose::tools
