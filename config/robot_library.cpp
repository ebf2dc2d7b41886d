#include "config/robot_library.hpp"

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

#include "config/number_text.hpp"
#include "config/text_file.hpp"

namespace truepose::config {
namespace {

namespace fs = std::filesystem;

/// Letters and digits alone, as "kr210" of "KR 210".
std::string compact_name(std::string_view name) {
  std::string compact;
  for (const char c : name)
    if (const auto letter = static_cast<unsigned char>(c); std::isalnum(letter))
      compact += static_cast<char>(std::tolower(letter));
  return compact;
}

/// ", did you mean 'kr210_r2700_2' or ..": the names that have it in them, else the one that is spelt alike.
std::string meant_by(const std::string& name, const std::vector<std::string>& known) {
  const std::string part = compact_name(name);
  std::string meant;
  for (const std::string& each : known)
    if (!part.empty() && compact_name(each).contains(part))
      meant += (meant.empty() ? ", did you mean " : " or ") + in_quotes(each);
  return meant.empty() ? suggestion(name, known) : meant + "?";
}

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
  const std::string meant = meant_by(file_or_name.string(), names);
  throw ConfigError{file_or_name.string() + ": no such file, and no shipped robot of this name" +
                    (meant.empty() ? "." : meant) + " See truepose robot list."};
}

}  // namespace truepose::config
