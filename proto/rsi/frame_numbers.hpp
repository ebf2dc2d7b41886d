#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "proto/rsi/frame_codec.hpp"
#include "proto/text/kuka_names.hpp"

namespace truepose::rsi {

/// Six attributes, and what is written before the value of each.
struct SixAttributes {
  SixNames names, openings;
};
inline constexpr SixAttributes kAxisAttributes{
    kAxisNames, {" A1=\"", "\" A2=\"", "\" A3=\"", "\" A4=\"", "\" A5=\"", "\" A6=\""}};
inline constexpr SixAttributes kExternalAttributes{
    {"E1", "E2", "E3", "E4", "E5", "E6"},
    {" E1=\"", "\" E2=\"", "\" E3=\"", "\" E4=\"", "\" E5=\"", "\" E6=\""}};
inline constexpr SixAttributes kPoseAttributes{
    kPoseNames, {" X=\"", "\" Y=\"", "\" Z=\"", "\" A=\"", "\" B=\"", "\" C=\""}};
inline constexpr std::array<std::string_view, 5> kProgramNames{"Ask", "Pro", "Mode", "Ov", "Cell"};

/// The elements of a robot frame that have six numbers, in the order in which controllers write them.
enum Six : std::size_t { kRIst, kRSol, kAIPos, kASPos, kEIPos, kESPos };
struct SixElement {
  std::string_view name;
  const SixAttributes& attributes;
};
inline constexpr std::array<SixElement, 6> kSixElements{{{"RIst", kPoseAttributes},
                                                         {"RSol", kPoseAttributes},
                                                         {"AIPos", kAxisAttributes},
                                                         {"ASPos", kAxisAttributes},
                                                         {"EIPos", kExternalAttributes},
                                                         {"ESPos", kExternalAttributes}}};

/// The numbers of a robot frame as they stand in it.
struct WireNumbers {
  std::uint64_t ipoc = 0;
  std::array<std::optional<Axes>, kSixElements.size()> six;  ///< by Six
  std::optional<std::int64_t> delay;
  std::array<std::optional<std::int64_t>, kProgramNames.size()> program;
};
RobotFrame robot_frame(const WireNumbers& numbers) noexcept;

}  // namespace truepose::rsi
