#pragma once

namespace truepose::steering {

/// What every program ends with that is no service.
enum ExitCode {
  kDone = 0,
  kFailed = 1,       ///< the work failed: not converged, validation worse, a target out of reach
  kBadInput = 2,     ///< usage, or a file that cannot be used
  kUnreachable = 3,  ///< the daemon or a device, or a port to listen on
};

}  // namespace truepose::steering
