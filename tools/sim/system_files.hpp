#pragma once

#include <span>

#include "config/controller_files.hpp"

namespace truepose::sim {

/// What KRC/R1/System of every controller has, as far as programs use it: "config.dat" is its $config.dat.
std::span<const EmbeddedText> system_files();

}  // namespace truepose::sim
