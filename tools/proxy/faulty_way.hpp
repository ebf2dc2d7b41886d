#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/random.hpp"

namespace truepose::proxy {

/// What befalls one direction of a route. Shares are of 1.
struct Faults {
  double delay_ms = 0;
  double jitter_ms = 0;  ///< up to so much more, uniformly
  double truncate = 0;   ///< share that loses its end, from a random byte on
  double corrupt = 0;    ///< share with one random byte changed
  double nul_bytes = 0;  ///< so many behind each datagram or piece
  // Datagrams alone:
  double loss = 0;       ///< share, in the long run
  double burst = 1;      ///< mean number of datagrams that are lost in a row
  double duplicate = 0;  ///< share that comes twice
  double reorder = 0;    ///< share that comes behind the next one
  // TCP alone:
  double bytes_per_s = 0;  ///< 0: as fast as it goes
  double coalesce_ms = 0;  ///< what comes within it arrives as one piece
  bool half_open = false;  ///< nothing continues, and the connection stays
};

struct Counters {
  std::uint64_t received = 0, bytes = 0, forwarded = 0, lost = 0, duplicated = 0, reordered = 0,
                truncated = 0, corrupted = 0;
};

/// One direction of a route: decides what becomes of each datagram or piece of a stream. No I/O and no clock;
/// what it does follows from its seed alone.
class FaultyWay {
 public:
  struct Outgoing {
    std::string bytes;
    std::chrono::microseconds delay{0};
  };

  explicit FaultyWay(std::uint64_t seed) : random_{seed} {}

  /// What continues now, in this order: none where it is lost or held back for the next one.
  std::vector<Outgoing> datagram(std::string_view bytes);
  /// A piece of a stream, of which nothing may be lost, doubled or overtaken.
  Outgoing piece(std::string_view bytes);

  Faults faults;
  const Counters& counters() const { return counters_; }

 private:
  bool happens(double share) { return random_.uniform() < share; }
  bool is_lost();
  Outgoing damaged(std::string_view bytes);

  Random random_;
  bool losing_ = false;  // in a burst
  std::optional<Outgoing> held_back_;
  Counters counters_;
};

}  // namespace truepose::proxy
