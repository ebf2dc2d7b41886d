#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace truepose::config {

/// A KRL file of an archive.
struct ArchiveFile {
  std::string path;  ///< inside of the archive: "KRC/R1/System/$config.dat"
  std::string text;  ///< byte for byte: the controller writes Latin-1
};

/// Reads the .src, .sub and .dat files of a controller's archive: of KRC/R1 and KRC/STEU where it has them.
/// @param archive  a folder that holds KRC or is R1 itself, or the .zip that the controller writes
/// @return sorted by path, at least one
/// Throws ConfigError: it cannot be read, has no such file, or more than kMostBytesOfFile of them.
std::vector<ArchiveFile> read_kuka_archive(const std::filesystem::path& archive);

}  // namespace truepose::config
