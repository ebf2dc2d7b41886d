#pragma once

#include <boost/asio/awaitable.hpp>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"

namespace truepose::world {

/// A person edits the active model in the store while the daemon does not run: changes a digit of it, or
/// lengthens a link and gives the text the hashes that it must have then.
boost::asio::awaitable<void> edit_model(Cell& cell, Random& random);

}  // namespace truepose::world
