#pragma once

#include <cstddef>

namespace truepose::tools {

/// Columns that a line may have: as COLUMNS says, else as the terminal is wide; 0: neither says.
std::size_t columns_of(int descriptor);

bool is_terminal(int descriptor);

/// Whether a verdict is coloured: on a terminal, unless NO_COLOR is set (no-color.org) or TERM is "dumb".
bool shows_colors(int descriptor);

/// How much a command says in addition to its answer.
struct Manner {
  bool quiet = false;    ///< no progress and no notes
  bool verbose = false;  ///< on a terminal too: whole ids, and times in UTC with milliseconds
};
Manner& manner();

/// Whether ids are shortened and times are local on standard output: people read it.
bool is_for_people();

}  // namespace truepose::tools
