#pragma once

#include <expected>
#include <map>

#include "proto/krl/frame_state.hpp"

namespace truepose::krl {

/// Where tools and bases may be set otherwise than reading a program in the order of its text tells.
struct FrameFlow {
  /// Behind the statement at this byte: by a routine that it calls, or behind TRIGGER ... DO;
  /// behind a label by what a GOTO to it passes over.
  std::map<std::size_t, FrameSettings> behind;
  FrameSettings interrupts;  ///< by what INTERRUPT DECL ... DO carries out, at any time
};

/// What the routines of programs set, by their names in capitals, those that they call included.
using RoutineSettings = std::map<std::string, FrameSettings, std::less<>>;

/// Of the programs of a text. Texts that cannot be read have none.
RoutineSettings routine_settings(const ProgramText& text);

/// @param file    that the text is
/// @param others  of routines that it calls and does not have itself
/// Errors: a text that is not closed in its line.
std::expected<FrameFlow, Fault> read_frame_flow(std::string_view src, std::size_t file,
                                                const RoutineSettings& others = {});

}  // namespace truepose::krl
