#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <span>
#include <string_view>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"

namespace truepose::world {

/// What a fault waits for.
enum class Waits {
  ForNothing,
  ForRsi,       ///< a session of it, and happens soon after it began
  ForCampaign,  ///< one that measures, and happens some poses later
};

/// What goes wrong in a cell, and how often.
struct FaultKind {
  std::string_view name;
  double per_day;
  Waits waits;
  /// Lets it happen, and returns once it is over.
  boost::asio::awaitable<void> (*happen)(Cell&, Random&);
};

/// Between two times, the shorter ones more often.
std::chrono::milliseconds lasting(Random& random, std::chrono::milliseconds shortest,
                                  std::chrono::milliseconds longest);

/// The table of all.
std::span<const FaultKind> fault_kinds();

}  // namespace truepose::world
