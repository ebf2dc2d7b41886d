#pragma once

#include <filesystem>
#include <string>

namespace truepose::daemon {

/// Why this user cannot make files in a folder, in the system's words; empty: he can.
std::string why_not_writable(const std::filesystem::path& folder);

}  // namespace truepose::daemon
