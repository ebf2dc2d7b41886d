#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::rsi {

/// What a frame of a controller has, whether we use it or not.
struct FrameElements {
  std::vector<std::string> names;  ///< "Tp.Ask" of an attribute, "IPOC" of an element without one
  int decimals = 0;                ///< the most that a number has: the ETHERNET object's Precision
};

/// Error: Malformed.
std::expected<FrameElements, FrameError> frame_elements(std::string_view frame);

/// What differs between a frame and the SEND list of a configuration.
struct NameDifference {
  std::vector<std::string> unknown;  ///< in the frame alone: "MACur", "Tp.Asks"
  std::vector<std::string> missing;  ///< in the configuration alone, by its tags: "DEF_RIst", "Tp.Ask"

  bool operator==(const NameDifference&) const = default;
};

NameDifference compare_names(const FrameElements& found, const EthernetConfig& ethernet);

}  // namespace truepose::rsi
