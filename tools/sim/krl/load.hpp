#pragma once

#include <expected>
#include <span>
#include <string>
#include <vector>

#include "tools/sim/krl/fault.hpp"
#include "tools/sim/krl/program.hpp"

namespace truepose::sim::krl {

/// A file of the controller: its name ends in .src, .sub or .dat. A .src or .sub and the .dat of the same
/// name are one module; all data of $config.dat is known to all modules.
struct Source {
  std::string file;
  std::string text;
  /// A statement that is not known stops the program where it comes to it, and a declaration that is not
  /// known declares nothing. Else it keeps everything from being loaded.
  bool is_partial = false;
};

/// Declarations of the controller in addition to the modules and standard.hpp. The host answers for all of
/// it, and for the system variables of standard.hpp.
struct Environment {
  /// KRL: ENUM, STRUC, system variables (all that begin with $: `DECL BOOL $FLAG[1024]`), data that all
  /// modules know (`DECL INT RSIOK=0`), subprograms (`EXT BAS(BAS_COMMAND:IN,REAL:IN)`, `EXTFCT INT
  /// RSI_OFF()`).
  std::string declarations;
  /// Names, in capitals, of further system variables and subprograms that do not stop the advance run.
  std::vector<std::string> pass_advance_run = {};
};

/// Compiles all modules. What is not known of partial sources is in Program::refusals.
/// Errors: the first that is found in another source, with file and line.
std::expected<Program, Fault> load(const Environment& environment, std::span<const Source> sources);

}  // namespace truepose::sim::krl
