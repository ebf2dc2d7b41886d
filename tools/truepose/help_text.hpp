#pragma once

#include <cstddef>
#include <string>

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// The command of this name, "campaign" or "campaign start"; null: none.
const Command* find_command(const CommandLine& line, const std::string& name);

/// The help of a command or of a group of commands.
///
/// @param command  null: of the whole program
/// @param width    columns of a line
std::string help_text(const CommandLine& line, const Command* command, std::size_t width);

}  // namespace truepose::tools
