#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/clock.hpp"
#include "tests/world/event_hash.hpp"

namespace truepose::world {

/// All that went over the wires of a world, as one number: two runs of a seed have the same.
class History {
 public:
  explicit History(const drivers::Clock& clock) : clock_{clock} {}

  /// @param wire  which one, and in what direction
  void add(std::string_view wire, std::string_view bytes) {
    hash_.add(std::to_string(drivers::nanoseconds_of(clock_.now())));
    hash_.add(wire);
    hash_.add(bytes);
    ++count_;
  }
  std::uint64_t hash() const { return hash_.value(); }
  std::uint64_t count() const { return count_; }

 private:
  const drivers::Clock& clock_;
  EventHash hash_;
  std::uint64_t count_ = 0;
};

}  // namespace truepose::world
