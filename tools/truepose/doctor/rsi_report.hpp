#pragma once

#include <boost/json/object.hpp>
#include <optional>
#include <string>

#include "proto/rsi/ethernet_config.hpp"
#include "tools/truepose/doctor/rsi_watch.hpp"

namespace truepose::tools {

/// Whether its frames are what the configuration has sent; without one any good frame is.
bool is_of_kind(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet);

/// {"source", "frames", "frames_per_s", "cycle_ms", "longest_ms", "ipoc", "ipoc_step", "delay",
/// "delay_rises", "decimals", "elements", "unknown", "missing", "malformed", "why_malformed"}; null for what
/// is not known.
boost::json::object sender_json(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet);

/// The same as lines for people.
std::string sender_text(const boost::json::value& sender);

/// "192.168.44.1:52000  250.0 frames/s  IPOC 123456  Delay 7", of a second.
/// @param frames  that it sent in it
std::string sender_line(const RsiSender& sender, std::uint64_t frames);

}  // namespace truepose::tools
