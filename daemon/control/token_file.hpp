#pragma once

#include <expected>
#include <filesystem>
#include <string>
#include <string_view>

namespace truepose::daemon {

/// Reads the secret that clients must show. Nobody but its owner may write the file, and nobody but we
/// and our own primary group may read it (0600, or 0640 as root gives it to the service's group). It holds at
/// least 16 characters; white space around them is dropped. The error is one sentence.
std::expected<std::string, std::string> read_token(const std::filesystem::path& file);

/// Compares in a time that depends on the length of `given` alone, so that a guess learns nothing from it.
bool same_token(std::string_view given, std::string_view secret);

}  // namespace truepose::daemon
