#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proto/recording/recording.hpp"

namespace truepose::daemon {

/// Something at a time of a recording.
struct ReplayNote {
  std::int64_t time_ns = 0;
  std::string text;
};

/// What became of the frames of one wire.
struct WireReport {
  recording::Wire wire{};
  std::uint64_t frames = 0;    ///< datagrams, documents or packets, of both sides
  std::uint64_t rejected = 0;  ///< of these, that could not be understood
  std::uint64_t sessions = 0;  ///< connections; of RSI sessions of the controller
  std::optional<ReplayNote> first_rejected;
  std::optional<ReplayNote> regression;  ///< a frame that was accepted when it was recorded, and is not now

  std::uint64_t decoded() const { return frames - rejected; }
};

/// What the stream of corrections did.
struct StreamReport {
  std::uint64_t datagrams = 0;  ///< that were given to a stream
  std::uint64_t compared = 0;   ///< replies, and datagrams that got none
  std::uint64_t different = 0;  ///< of these
  std::optional<ReplayNote> first_different;
  std::vector<std::string> not_compared;  ///< why others were not, a sentence each
  std::vector<ReplayNote> faults;
  std::map<std::string, std::uint64_t> counters;  ///< StreamCounters, by their names
  double max_step_deg = 0;
};

/// What the drivers of robot and tracker did that were asked again what the recorded ones had been asked.
struct DriverReport {
  std::string name;         ///< "robot" or "tracker"
  std::uint64_t calls = 0;  ///< in the recording
  std::uint64_t same = 0;   ///< of these, that ended as they had, everything sent meanwhile included
  std::uint64_t different = 0;
  std::optional<ReplayNote> first_different;
  std::map<std::string, std::uint64_t> not_judged;  ///< the others, by why
};

struct ReplayReport {
  std::uint64_t records = 0;
  std::uint64_t dropped = 0;  ///< for which there was no room when it was recorded
  std::int64_t begin_ns = 0, end_ns = 0;
  std::vector<WireReport> wires;  ///< those that have records
  StreamReport stream;
  std::vector<DriverReport> drivers;        ///< whose calls the recording has
  std::vector<ReplayNote> recorded_faults;  ///< as the daemon told of them
  std::string damage;                       ///< why the file was read in part; empty: it is whole

  /// Whether the drivers and the stream do what they did when it was recorded.
  bool same() const;
};

/// Feeds a recording to the drivers' decoders, to the drivers and to a stream of corrections, at the times
/// that it tells.
/// @param only  wire that alone is replayed; a driver is with that which tells of its calls
/// @return what came of it; or one sentence, where the header does not make a stream
std::expected<ReplayReport, std::string> replay(const recording::Recording& recording,
                                                std::optional<recording::Wire> only = {});

}  // namespace truepose::daemon
