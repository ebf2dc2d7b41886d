#pragma once

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

// The commands that work on files alone. Each writes its results to standard output, and ends with kFailed
// where:

Command calibrate_command();   ///< the identification did not converge, or made things worse
Command compensate_command();  ///< a target cannot be reached
Command doctor_command();      ///< a fault was found
Command drift_command();  ///< the model is no longer right; without a file the daemon measures and judges
Command experiment_command();  ///< the two-stage fit did not converge in every trial
Command export_command();
Command fk_command();
Command iso9283_command();
Command kuka_commands();
Command kuka_write_command();
Command kuka_lint_command();  ///< something was found
Command listen_command();     ///< no good frame of the configured kind came
Command plan_command();
Command replay_command();  ///< a driver or the stream does something else than when it was recorded

}  // namespace truepose::tools
