#pragma once

#include <cstddef>
#include <expected>
#include <filesystem>
#include <string>

namespace truepose::daemon {

/// Reads a file that holds secrets, or says who is let in. Nobody but its owner may write it, and nobody but
/// we and our own primary group may read it (0600, or 0640 as root gives it to the service's group).
///
/// @param most  bytes that are read
/// @return its text; else one phrase, with the command that fixes it where there is one
std::expected<std::string, std::string> read_private_file(const std::filesystem::path& file,
                                                          std::size_t most);

}  // namespace truepose::daemon
