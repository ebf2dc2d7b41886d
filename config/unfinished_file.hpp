#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace truepose::config {

/// A file that takes its place, or replaces the one there, only once it is written in full and on the disk:
/// until then it lies beside it under another name, and goes away if it is given up. What is no file (a pipe,
/// a terminal) is written to as it is. Every function throws ConfigError where it fails.
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

struct TextFile {
  std::filesystem::path path;
  std::string text;
};

/// Writes files that belong together: none of them appears, or is replaced, before all are written in full
/// beside their places. Throws ConfigError.
void write_together(const std::vector<TextFile>& files);

}  // namespace truepose::config
