#include "tools/truepose/written_files.hpp"

#include <filesystem>

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;

struct NamedFile {
  const Option* option;
  fs::path path;
};

std::vector<fs::path> paths_of(const OptionTarget& target) {
  return std::visit(
      []<class T>(const T* value) -> std::vector<fs::path> {
        if constexpr (std::convertible_to<T, fs::path>) return {*value};
        if constexpr (std::same_as<T, std::vector<std::string>>) return {value->begin(), value->end()};
        return {};
      },
      target);
}

bool is_same(const fs::path& a, const fs::path& b) {
  std::error_code none;
  const fs::file_status of_a = fs::status(a, none), of_b = fs::status(b, none);
  if (fs::exists(of_a) && fs::exists(of_b)) return fs::is_regular_file(of_a) && fs::equivalent(a, b, none);
  return fs::weakly_canonical(fs::absolute(a)) == fs::weakly_canonical(fs::absolute(b));
}

}  // namespace

void refuse_overwriting(std::initializer_list<std::span<const Option>> options) {
  std::vector<NamedFile> read, written;
  for (const std::span<const Option> some : options) {
    for (const Option& option : some) {
      if (option.rules.file == FileUse::None) continue;
      std::vector<NamedFile>& files = option.rules.file == FileUse::Read ? read : written;
      for (const fs::path& path : paths_of(option.target))
        if (!path.empty() && path != "-") files.push_back({&option, path});
    }
  }
  std::vector<NamedFile>& others = read;
  for (const NamedFile& file : written) {
    for (const NamedFile& other : others) {
      if (is_same(file.path, other.path))
        throw CommandError{kBadInput, file.option->name + ": " + file.path.string() + " is the file of " +
                                          other.option->name +
                                          " too, which would be lost; write to another file"};
    }
    others.push_back(file);
  }
}

void note_written(std::initializer_list<fs::path> files) {
  for (const fs::path& file : files)
    if (!file.empty() && file != "-") print_to_stderr(file.string() + ": written");
}

}  // namespace truepose::tools
