#pragma once

#include <filesystem>
#include <string_view>

namespace truepose::sim {

/// Writes a file so that a reader sees it whole or not at all. Throws std::system_error that names the file.
void write_whole(const std::filesystem::path& file, std::string_view text);

}  // namespace truepose::sim
