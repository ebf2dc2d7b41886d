#pragma once

#include <map>
#include <span>

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

/// Of the programs of a text.
/// @param statements  of each of its files; none of one that cannot be read
RoutineSettings routine_settings(const ProgramText& text,
                                 std::span<const std::vector<ProgramStatement>> statements);

/// @param file    that the statements stand in
/// @param others  of routines that it calls and does not have itself
FrameFlow frame_flow(Statements statements, std::size_t file, const RoutineSettings& others);

}  // namespace truepose::krl
