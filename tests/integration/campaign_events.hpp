#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/control/request.hpp"
#include "tests/integration/live_cell.hpp"

namespace truepose {

/// What the daemon answers. @throws std::runtime_error where it refuses
boost::json::value called(tools::RpcClient& client, const std::string& method,
                          const boost::json::object& params = {});

/// Events up to the first that fits, which is the last of them.
template <typename Fits>
std::vector<control::Event> events_until(tools::RpcClient& client, Fits fits) {
  std::vector<control::Event> events;
  do {
    auto event = client.next_event();
    if (!event) throw std::runtime_error{event.error().message};
    events.push_back(*std::move(event));
  } while (!fits(events.back()));
  return events;
}

bool is_end_of_campaign(const control::Event& event);

/// Runs a campaign in whose simulated cell something happens at each measured pose, on however fast a
/// machine. Whenever it pauses it is resumed.
/// @param happens  for the simulator's admin port, of the number of measured poses; empty: nothing
/// @param when_lost  for the same, whenever a device has to be waited for; empty: nothing
/// @return the events of campaign, cell and log
std::vector<control::Event> campaign_in_trouble(
    const LiveCell& cell, const boost::json::object& params,
    const std::function<boost::json::object(std::int64_t measured)>& happens,
    const boost::json::object& when_lost = {});
/// That a device has to be waited for.
bool is_loss(const control::Event& event);

}  // namespace truepose
