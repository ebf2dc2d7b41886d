#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "config/config_error.hpp"

namespace truepose::config {

/// A file opened to be read byte for byte. Throws ConfigError where it cannot be.
std::ifstream open_to_read(const std::filesystem::path& file);

/// The whole of a file, byte for byte. Throws ConfigError where it cannot be read.
std::string read_bytes(const std::filesystem::path& file);

/// The whole text of a file, without a byte order mark. Throws ConfigError where it cannot be read.
std::string read_text_file(const std::filesystem::path& file);

/// Writes the whole of a file. Throws ConfigError where that fails.
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace truepose::config
