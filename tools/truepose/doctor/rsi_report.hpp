#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/record/layout.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "tools/truepose/doctor/rsi_watch.hpp"

namespace truepose::tools {

/// Whether its frames are what the configuration has sent; without one any good frame is.
bool is_of_kind(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet);

/// What a sender sends, as `truepose listen` prints it; empty for what is not known.
struct SenderReport {
  std::string source;
  std::uint64_t frames = 0;
  std::optional<double> frames_per_s, cycle_ms;
  double longest_ms = 0;
  std::optional<std::uint64_t> ipoc, ipoc_step;
  std::optional<std::int64_t> delay;
  bool delay_rises = false;
  std::optional<int> decimals;
  std::vector<std::string> elements;
  std::optional<std::vector<std::string>> unknown, missing;  ///< against the configuration
  std::uint64_t malformed = 0;
  std::optional<std::string> why_malformed;
};
void layout(record::Io& io, SenderReport& x);
SenderReport sender_report(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet);

/// The same as lines for people.
std::string sender_text(const SenderReport& sender);

/// "192.168.44.1:52000  250.0 frames/s  IPOC 123456  Delay 7", of a second.
/// @param frames  that it sent in it
std::string sender_line(const RsiSender& sender, std::uint64_t frames);

}  // namespace truepose::tools
