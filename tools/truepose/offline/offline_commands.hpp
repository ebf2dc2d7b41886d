#pragma once

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

// The commands that work on files alone. Each writes its results to standard output, and ends with kFailed
// where:

Command access_commands();
Command access_add_command();  ///< the name is taken
Command access_list_command();
Command access_revoke_command();  ///< there is no such name
Command audit_verify_command();   ///< something was changed, or is missing
Command base_command();           ///< readings tell no frame, or contradict each other
Command bridge_check_command();   ///< a promise of the protocol is not kept
Command calibrate_command();      ///< a test of the verdict failed
Command compensate_command();     ///< a target cannot be reached
Command data_commands();
Command data_check_command();  ///< something was found
Command doctor_command();      ///< a fault was found
Command drift_command();  ///< the model is no longer right; without a file the daemon measures and judges
Command export_command();
Command fk_command();
Command iso9283_command();
Command kuka_commands();
Command kuka_write_command();
Command kuka_lint_command();  ///< something was found
Command listen_command();     ///< no good frame of the configured kind came
Command plan_command();
Command positioner_command();  ///< as base_command(), or the root stands on its head
Command robot_commands();
Command robot_check_command();  ///< a position differs by more than the limits
Command robot_export_command();
Command robot_import_command();
Command robot_list_command();
Command robot_new_command();
Command robot_show_command();
Command robot_fix_command();  ///< nothing was found, nothing that can be fixed, or several that fit equally
Command replay_command();     ///< a driver or the stream does something else than when it was recorded
Command restore_command();    ///< the copy cannot be used, or a daemon has the store
Command tls_commands();
Command tls_init_command();
Command tls_client_command();  ///< its certificate is there already
Command tool_command();        ///< as base_command()

}  // namespace truepose::tools
