#pragma once

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

// Commands that set up a cell. They run programs of the same installation.

Command cell_commands();
Command cell_demo_command();  ///< ends as the command of it that failed first
Command cell_new_command();   ///< ends as trueposed --check --probe

}  // namespace truepose::tools
