#pragma once

#include <filesystem>
#include <fstream>

namespace truepose::tools {

/// A file that takes its place, or replaces the one there, only once it is written in full: until then it
/// lies beside it under another name, and goes away if it is given up. What is no file (a pipe, a terminal)
/// is written to as it is. Every function throws ConfigError where it fails.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::filesystem::path& path);
  ~UnfinishedFile();
  UnfinishedFile(UnfinishedFile&&) = default;
  UnfinishedFile& operator=(UnfinishedFile&&) = delete;

  std::ostream& stream() { return out_; }
  /// All is written.
  void close();
  /// After close().
  void take_place();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path path_, beside_;  // beside_: empty where there is nothing to clean up
  std::ofstream out_;
};

}  // namespace truepose::tools
