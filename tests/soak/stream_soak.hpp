#pragma once

#include <cstdint>

#include "tests/daemon/stream_cell.hpp"

namespace truepose::soak {

/// What a soak of the correction stream came to. Broken promises are reported as test failures where they
/// break.
struct StreamSoak : daemon::StreamHistory {
  double hours = 0;
  int cells = 0;
  std::uint64_t hash = 0;  ///< of every reply, in order
};

/// Runs StreamCells in virtual time, some hours each, of 4 and of 12 ms, where what befalls them leaves the
/// stream time to come to full correction in between; and sees that no cell is shown as correcting by an old
/// packet, and that neither memory nor file descriptors are used up.
StreamSoak soak_stream(std::uint64_t seed, double hours);

}  // namespace truepose::soak
