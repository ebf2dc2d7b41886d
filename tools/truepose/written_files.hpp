#pragma once

#include <filesystem>
#include <initializer_list>
#include <span>

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// Refuses options by which a file would be written that is read too, or written by another of them: under
/// another name, by a link to it or in another folder's words, too. What is no file (a pipe, a terminal,
/// /dev/null) may be named twice. Throws CommandError.
void refuse_overwriting(std::initializer_list<std::span<const Option>> options);

/// Says on standard error which files a command wrote; nothing of empty names and of "-".
void note_written(std::initializer_list<std::filesystem::path> files);

}  // namespace truepose::tools
