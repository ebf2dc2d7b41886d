#pragma once

namespace truepose::tools {

/// What every command ends with.
enum ExitCode {
  kDone = 0,
  kFailed = 1,       ///< the work failed: not converged, validation worse, a target out of reach
  kBadInput = 2,     ///< usage, or a file that cannot be used
  kUnreachable = 3,  ///< the daemon or a device
};

}  // namespace truepose::tools
