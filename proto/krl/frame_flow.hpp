#pragma once

#include <expected>
#include <map>

#include "proto/krl/frame_state.hpp"

namespace truepose::krl {

/// Where tools and bases may be set otherwise than reading a program in the order of its text tells.
struct FrameFlow {
  /// Behind the statement at this byte: by a routine of the program that it calls, or behind TRIGGER ... DO;
  /// behind a label by what a GOTO to it passes over.
  std::map<std::size_t, FrameSettings> behind;
  FrameSettings interrupts;  ///< by what INTERRUPT DECL ... DO carries out, at any time
};

/// Errors: a text that is not closed in its line.
std::expected<FrameFlow, Fault> read_frame_flow(std::string_view src);

}  // namespace truepose::krl
