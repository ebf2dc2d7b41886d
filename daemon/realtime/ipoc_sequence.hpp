#pragma once

#include <cstdint>
#include <optional>

namespace truepose::daemon {

/// Tells from a datagram's time stamp (IPOC) whether it is the next of its session, an old one, or the first
/// of a session after the controller was started anew. The step from cycle to cycle is learned.
class IpocSequence {
 public:
  enum class Place { Next, Duplicate, Stale, NewSession };
  struct Position {
    Place place = Place::Next;
    std::uint64_t forward = 0;  ///< IPOC since the last datagram
    std::uint64_t elapsed = 1;  ///< the same in cycles
  };

  /// @param timeout_cycles  a gap of more begins a new session: by then the controller has given up
  explicit IpocSequence(int timeout_cycles) : patience_{static_cast<std::uint64_t>(timeout_cycles)} {}

  Position place(std::uint64_t ipoc) const noexcept;
  /// Whether a datagram placed as NewSession really begins one. A single one is a damaged time stamp: a
  /// session begins with the second of its own, but for the very first.
  bool confirms_session(std::uint64_t ipoc) noexcept;

  void start(std::uint64_t ipoc) noexcept;
  void advance(std::uint64_t ipoc, const Position& position) noexcept;

  std::uint64_t last() const noexcept { return last_; }
  std::uint64_t step() const noexcept { return step_; }  ///< IPOC per cycle; 0 = not yet known

 private:
  std::uint64_t patience_;
  bool begun_ = false;
  std::uint64_t last_ = 0;
  std::uint64_t step_ = 0;
  std::uint64_t last_forward_ = 0;
  std::optional<std::uint64_t> new_session_;  // IPOC of a datagram that may be the first of a new session
};

}  // namespace truepose::daemon
