#pragma once

#include <expected>
#include <filesystem>
#include <string>
#include <string_view>

namespace truepose::daemon {

/// Reads the secret that clients must show. The file must be ours alone (mode 0600 or stricter) and hold at
/// least 16 characters; white space around them is dropped. The error is one sentence.
std::expected<std::string, std::string> read_token(const std::filesystem::path& file);

/// Compares in a time that depends on the length of `given` alone, so that a guess learns nothing from it.
bool same_token(std::string_view given, std::string_view secret);

}  // namespace truepose::daemon
