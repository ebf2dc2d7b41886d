#pragma once

#include <boost/asio/awaitable.hpp>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"

namespace truepose::world {

/// An HMI that only shows the cell, for good: until `calm` it is switched off, dies within a line, or reads
/// nothing for a while. It connects again, and continues with the events that it missed.
boost::asio::awaitable<void> show(Cell& cell, Client& viewer, Random random, drivers::TimePoint calm);

}  // namespace truepose::world
