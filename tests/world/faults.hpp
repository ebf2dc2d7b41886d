#pragma once

#include <boost/asio/awaitable.hpp>
#include <span>
#include <string_view>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"

namespace truepose::world {

/// What goes wrong in a cell, and how often.
struct FaultKind {
  std::string_view name;
  double per_day;
  bool of_rsi;  ///< happens while a session runs, and waits for one
  /// Lets it happen, and returns once it is over.
  boost::asio::awaitable<void> (*happen)(Cell&, Random&);
};

/// The table of all.
std::span<const FaultKind> fault_kinds();

}  // namespace truepose::world
