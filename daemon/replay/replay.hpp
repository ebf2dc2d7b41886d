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

/// What the stream of corrections did.
struct StreamReport {
  std::uint64_t datagrams = 0;  ///< that were given to a stream
  std::uint64_t rejected = 0;   ///< of these, that could not be read
  std::optional<ReplayNote> first_rejected;
  std::uint64_t sessions = 0;   ///< of the controller
  std::uint64_t compared = 0;   ///< replies, and datagrams that got none
  std::uint64_t different = 0;  ///< of these
  std::optional<ReplayNote> first_different;
  std::vector<std::string> not_compared;  ///< why others were not, a sentence each
  std::vector<ReplayNote> faults;
  std::map<std::string, std::uint64_t> counters;  ///< StreamCounters, by their names
  double max_step_deg = 0;
};

struct ReplayReport {
  std::uint64_t records = 0;
  std::uint64_t dropped = 0;  ///< for which there was no room when it was recorded
  std::int64_t begin_ns = 0, end_ns = 0;
  StreamReport stream;
  std::vector<ReplayNote> recorded_faults;  ///< as the daemon reported them
  std::string damage;                       ///< why the file was read in part; empty: it is whole

  /// Whether the stream gives the replies that it gave when it was recorded.
  bool same() const { return stream.different == 0; }
};

/// Feeds the datagrams of a recording to a stream of corrections, at their times.
/// @return what came of it; or one sentence, where the header does not make a stream
std::expected<ReplayReport, std::string> replay(const recording::Recording& recording);

}  // namespace truepose::daemon
