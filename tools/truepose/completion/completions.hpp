#pragma once

#include <string>
#include <vector>

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// What a shell may put in the place of the last word: a line each, the word and behind a tab what it is, or
/// ":files" or ":dirs" for the shell's own names of files or folders.
///
/// @param words  behind the program's name, as far as they are typed; the last may be a part or empty
std::string completions(const CommandLine& line, const std::vector<std::string>& words);

}  // namespace truepose::tools
