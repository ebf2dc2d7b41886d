#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

#include "config/config_error.hpp"

namespace truepose::config {

/// A file opened to be read byte for byte. Throws ConfigError where it cannot be.
std::ifstream open_to_read(const std::filesystem::path& file);

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

}  // namespace truepose::config
