#pragma once

#include <cstdint>

namespace truepose::soak {

/// What a soak of the correction stream came to. Broken invariants are reported as test failures where they
/// break.
struct StreamSoak {
  double hours = 0;
  std::uint64_t cycles = 0, answered = 0, held = 0, lost = 0, sessions = 0;
  double max_step_deg = 0;
  std::uint64_t hash = 0;  ///< of every reply, in order
};

/// Runs the RSI cycle in virtual time against a controller whose datagrams are lost, repeated and damaged,
/// whose program is stopped and started, while models come and go.
StreamSoak soak_stream(std::uint64_t seed, double hours);

}  // namespace truepose::soak
