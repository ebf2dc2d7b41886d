#pragma once

#include <filesystem>
#include <vector>

namespace truepose::config {

/// The robot files that came with the program, by name: those of share/truepose/robots next to it, or of
/// config/robots of the source tree that it was built in. Empty where there is no such folder.
std::vector<std::filesystem::path> shipped_robot_files();

/// The file itself where it exists; the shipped one where a bare name such as kr210_r2700_2 is given;
/// otherwise the path as given, which then cannot be read. Throws ConfigError for a bare name that is none of
/// the shipped.
///
/// @param folder  in which the file is looked for, where it is not absolute
std::filesystem::path robot_file_of(const std::filesystem::path& file_or_name,
                                    const std::filesystem::path& folder = {});

}  // namespace truepose::config
