#pragma once

#include <boost/asio/awaitable.hpp>
#include <map>
#include <string>

#include "tests/world/world.hpp"

namespace truepose::world {

/// What /metrics of the web port has now: numbers by their names with labels, as
/// truepose_cell_state{state="ready"}. Empty where there is no answer.
boost::asio::awaitable<std::map<std::string, double>> metrics(World& world);

}  // namespace truepose::world
