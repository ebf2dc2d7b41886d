#include "config/robot_library.hpp"

#include <algorithm>
#include <string>

#include "config/number_text.hpp"
#include "config/text_file.hpp"

namespace truepose::config {
namespace {

namespace fs = std::filesystem;

fs::path shipped_folder() {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  for (fs::path folder = program.parent_path(); folder.has_relative_path(); folder = folder.parent_path()) {
    for (const char* robots : {"share/truepose/robots", "config/robots"})
      if (fs::is_directory(folder / robots, none)) return folder / robots;
  }
  return {};
}

}  // namespace

std::vector<fs::path> shipped_robot_files() {
  std::vector<fs::path> files;
  const fs::path folder = shipped_folder();
  if (folder.empty()) return files;
  for (const auto& entry : fs::directory_iterator{folder})
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

fs::path robot_file_of(const fs::path& file_or_name, const fs::path& folder) {
  const fs::path given = folder.empty() ? file_or_name : (folder / file_or_name).lexically_normal();
  if (file_or_name.has_parent_path() || file_or_name.has_extension() || fs::exists(given)) return given;
  std::vector<std::string> names;
  for (const fs::path& file : shipped_robot_files()) {
    if (file.stem() == file_or_name) return file;
    names.push_back(file.stem());
  }
  if (names.empty()) return given;
  throw ConfigError{file_or_name.string() + ": no such file, and no shipped robot of this name" +
                    suggestion(file_or_name.string(), names) + ". See truepose robot list."};
}

}  // namespace truepose::config
