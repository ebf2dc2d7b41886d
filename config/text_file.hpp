#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace truepose::config {

/// A file that cannot be used. what() is the one line for the operator: "cell.yaml:12:9: tracker.port:
/// expected 1..65535, found 99999", or "poses.csv: row 7: q3: not a number: 'abc'".
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file opened to be read byte for byte. Throws ConfigError where it cannot be.
std::ifstream open_to_read(const std::filesystem::path& file);

/// Whether it is a file, no link, that belongs to our own user. In a folder that others may write to too,
/// another one may only look like ours.
bool is_own_file(const std::filesystem::path& file);
/// The same of such a file alone, whatever takes its place meanwhile.
std::ifstream open_own_to_read(const std::filesystem::path& file);

/// More than any file of ours has.
inline constexpr std::size_t kMostBytesOfFile = std::size_t{256} << 20;

/// The whole of a file, byte for byte. Throws ConfigError where it cannot be read or has more than `most`
/// bytes.
std::string read_bytes(const std::filesystem::path& file, std::size_t most = kMostBytesOfFile);

/// The whole text of a file, without a byte order mark. Throws ConfigError in the same cases.
std::string read_text_file(const std::filesystem::path& file, std::size_t most = kMostBytesOfFile);

/// Writes a file that is seen whole or not at all. Throws ConfigError where that fails, and leaves the file
/// that was there.
void write_text_file(const std::filesystem::path& file, const std::string& text);

/// The folder that a file is in: of a bare name the one that we are in.
std::filesystem::path folder_of(const std::filesystem::path& file);

/// Puts a file, or the names in a folder, on the disk. @return false with errno where that fails
bool synced(const std::filesystem::path& path);

/// A file that is created, or replaces an existing one, only after all of it is written and synced. Until
/// then the text is in a temporary file in the same folder, which is removed if the file is given up. It gets
/// no more permissions than the replaced file had. A pipe or a terminal is written to directly. Every
/// function throws ConfigError where it fails.
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

  std::filesystem::path path_, temporary_;  // temporary_: empty if there is nothing to clean up
  std::ofstream out_;
};

/// A file to be and what shall be in it.
struct TextFile {
  std::filesystem::path path;
  std::string text;
};

/// Writes files that belong together: none of them appears, or is replaced, before all are written in full to
/// temporary files in their folders. Throws ConfigError.
void write_together(const std::vector<TextFile>& files);

}  // namespace truepose::config
