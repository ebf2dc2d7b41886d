#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "proto/krl/frame_state.hpp"

namespace truepose::krl {

/// Where tools and bases may be set otherwise than reading a program in the order of its text tells.
struct FrameFlow {
  /// Behind the statement at this byte: by a routine that it calls, or behind TRIGGER ... DO;
  /// behind a label by what a GOTO to it passes over.
  std::map<std::size_t, FrameSettings> behind;
  FrameSettings interrupts;  ///< by what INTERRUPT DECL ... DO carries out, at any time
};

/// A statement that sets tool or base, calls, or is the end of a routine or a jump.
struct FrameAct {
  std::size_t at = 0, routine = 0;
  FrameSettings set;               ///< by itself
  std::vector<std::string> calls;  ///< names in capitals; that of a head is its own
  std::string label, jump;         ///< in capitals; empty where it is none
  bool is_head = false, is_later = false, is_interrupt = false;
};
using FrameActs = std::vector<FrameAct>;
/// @param file  that the statements stand in
FrameActs frame_acts(const TextStatements& statements, std::size_t file);

/// What the routines of programs set, by their names in capitals, those that they call included.
using RoutineSettings = std::map<std::string, FrameSettings, std::less<>>;

/// Of the programs of a text.
/// @param acts  of each of its files; none of one that cannot be read
RoutineSettings routine_settings(const ProgramText& text, std::span<const FrameActs> acts);

/// @param acts    of a file
/// @param others  of routines that it calls and does not have itself
FrameFlow frame_flow(const FrameActs& acts, const RoutineSettings& others);

}  // namespace truepose::krl
