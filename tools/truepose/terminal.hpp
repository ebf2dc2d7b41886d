#pragma once

#include <cstddef>

namespace truepose::tools {

/// Columns that a line may have: as COLUMNS says, else as the terminal is wide; 0: neither says.
std::size_t columns_of(int descriptor);

bool is_terminal(int descriptor);

/// Whether a verdict is coloured: on a terminal, unless NO_COLOR is set (no-color.org) or TERM is "dumb".
bool shows_colors(int descriptor);

}  // namespace truepose::tools
