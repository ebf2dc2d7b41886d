#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace truepose {

/// A folder of its own for one test, removed with everything in it at the end.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "truepose-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~TempFolder() { std::filesystem::remove_all(path_); }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

/// While it lives, the process stands in a folder: names without one are of there.
class StandsIn {
 public:
  explicit StandsIn(const std::filesystem::path& folder) { std::filesystem::current_path(folder); }
  ~StandsIn() { std::filesystem::current_path(before_); }
  StandsIn(const StandsIn&) = delete;
  StandsIn& operator=(const StandsIn&) = delete;

 private:
  std::filesystem::path before_ = std::filesystem::current_path();
};

}  // namespace truepose
