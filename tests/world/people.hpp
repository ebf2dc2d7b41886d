#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <string>

#include "tests/world/cell.hpp"

namespace truepose::world {

// What people do in a cell, as scripts for World::play(). A test fails where the daemon refuses.

/// The `result` of a request of the panel.
boost::asio::awaitable<boost::json::object> asked(Cell& cell, std::string method,
                                                  boost::json::object params = {});
/// Opens the panel's session, again and again while the daemon starts.
boost::asio::awaitable<void> connect(Cell& cell);
/// Waits until no campaign runs or pauses.
boost::asio::awaitable<void> campaign_over(Cell& cell);
/// Of a few poses.
boost::asio::awaitable<boost::json::object> start_campaign(Cell& cell);
/// Measures a few poses, and has the model activated.
boost::asio::awaitable<void> calibrate(Cell& cell);

}  // namespace truepose::world
