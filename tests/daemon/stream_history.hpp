#pragma once

#include <cstdint>

#include "tests/daemon/stream_cell.hpp"

namespace truepose::daemon {

/// A cell that the seed makes up, and some seconds in which everything happens to it that can.
StreamHistory stream_history(std::uint64_t seed);

}  // namespace truepose::daemon
