#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <fstream>
#include <ios>
#include <string>

#include "config/text_file.hpp"

namespace truepose::daemon {

/// So much of a file fits into a line of the protocol as base64.
inline constexpr std::size_t kPart = std::size_t{32} << 10;

/// The part of a file of our own that begins at a byte; empty at the end. Blocks. The error is one sentence.
inline std::expected<std::string, std::string> part_of(const std::filesystem::path& file,
                                                       std::uint64_t offset) try {
  std::string part(kPart, '\0');
  std::ifstream in = config::open_own_to_read(file);
  in.seekg(static_cast<std::streamoff>(offset));
  in.read(part.data(), static_cast<std::streamsize>(part.size()));
  part.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return part;
} catch (const config::ConfigError& error) {
  return std::unexpected(error.what());
}

}  // namespace truepose::daemon
