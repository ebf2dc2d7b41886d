#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rsi/ethernet_config.hpp"

namespace truepose::sim {

/// What the replies of a PC are made of, against the RECEIVE list that a controller has loaded. A real one
/// ignores the rest without a word, and then moves nothing.
class ReplyNames {
 public:
  explicit ReplyNames(const rsi::EthernetConfig& ethernet);

  /// Names in the reply that the list does not have, each told once: "AKorr", "AK.A7".
  std::vector<std::string> new_strangers(std::string_view reply);

 private:
  std::set<std::string, std::less<>> elements_, names_;  // "AK"; "AK.A1" and "Stop"
  std::set<std::string, std::less<>> told_;
};

}  // namespace truepose::sim
