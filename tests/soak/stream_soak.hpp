#pragma once

#include <cstdint>

namespace truepose::soak {

/// What a soak of the correction stream came to. Broken promises are reported as test failures where they
/// break.
struct StreamSoak {
  double hours = 0;
  int cells = 0;
  std::uint64_t cycles = 0, heard = 0, answered = 0;
  std::uint64_t sessions = 0, restarts = 0, stalls = 0, silences = 0, foreign = 0;
  double greatest_step = 0;  ///< at the controller, in bounds of a cycle
  double greatest_correction_deg = 0;
  std::uint64_t hash = 0;  ///< of every reply, in order
};

/// Runs StreamCells in virtual time, some hours each, of 4 and of 12 ms, where what befalls them leaves the
/// stream time to come to full correction in between; and sees that no cell is shown as correcting by an old
/// packet, and that neither memory nor file descriptors are used up.
StreamSoak soak_stream(std::uint64_t seed, double hours);

}  // namespace truepose::soak
