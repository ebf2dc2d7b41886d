#pragma once

#include <cstdint>
#include <string>

namespace truepose::daemon {

/// What one controller and its stream went through, and how it ended.
struct StreamHistory {
  std::uint64_t cycles = 0;    ///< of the controller's sessions
  std::uint64_t heard = 0;     ///< of these, by a daemon that runs
  std::uint64_t answered = 0;  ///< with a reply that it took
  std::uint64_t sessions = 0;  ///< of the controller, the first included
  std::uint64_t restarts = 0;  ///< of the daemon
  std::uint64_t foreign = 0;   ///< datagrams of others
  double greatest_step = 0;  ///< of a correction in force, in bounds of a cycle: 1 = as much as was promised
  double greatest_correction_deg = 0;
  std::string worst;  ///< when and where, and in which cell
};

/// A cell that the seed makes up, and some seconds in which everything happens to it that can: a second
/// sender, losses of any length in either direction, datagrams that overtake each other, restarts of
/// controller, daemon and machine, commands of operators; lag up to 100 ms, up to 200 deg/s, corrections up
/// to 3 deg.
StreamHistory stream_history(std::uint64_t seed);

}  // namespace truepose::daemon
