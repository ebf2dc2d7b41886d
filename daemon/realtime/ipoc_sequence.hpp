#pragma once

#include <cstdint>

namespace truepose::daemon {

/// Tells from a datagram's time stamp (IPOC) whether it is the next of its session, an old one, or one that
/// does not fit. The step from cycle to cycle is learned.
class IpocSequence {
 public:
  enum class Place {
    Next,       ///< goes on from the last, perhaps after a gap
    Duplicate,  ///< the last once more
    Stale,      ///< from before the last, or between two cycles
    Jump,       ///< too far ahead or behind: damaged, or of a controller that counts anew
  };
  struct Position {
    Place place = Place::Next;
    std::uint64_t forward = 0;  ///< IPOC since the last datagram; 0 where it does not lie ahead
    std::uint64_t elapsed = 1;  ///< the same in cycles
  };

  /// @param gap_cycles  a datagram further ahead than so many cycles must be borne out by others
  explicit IpocSequence(int gap_cycles) : gap_cycles_{static_cast<std::uint64_t>(gap_cycles)} {}

  bool begun() const noexcept { return begun_; }
  Position place(std::uint64_t ipoc) const noexcept;
  /// Whether a datagram that does not follow is the controller's new count all the same: the third in a row
  /// that goes on from the one before it. A single one is a damaged stamp, two may have overtaken each other.
  bool bears_out(std::uint64_t ipoc) noexcept;

  /// Begins a count, of which nothing is known but the step, where the caller knows that too.
  void start(std::uint64_t ipoc, std::uint64_t step = 0) noexcept;
  void advance(std::uint64_t ipoc, const Position& position) noexcept;

  std::uint64_t last() const noexcept { return last_; }
  std::uint64_t step() const noexcept { return step_; }  ///< IPOC per cycle; 0 = not yet known

 private:
  std::uint64_t gap_cycles_;
  bool begun_ = false;
  std::uint64_t last_ = 0;
  std::uint64_t step_ = 0;
  std::uint64_t last_forward_ = 0;
  std::uint64_t other_ = 0;  // the last datagram that did not follow
  int others_ = 0;           // so many of them in a row, each after the one before
};

}  // namespace truepose::daemon
