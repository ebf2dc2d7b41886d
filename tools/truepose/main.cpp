#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/online/online_commands.hpp"

int main(int argc, char** argv) {
  using namespace truepose::tools;
  CommandLine line = online_commands();
  line.commands.insert(
      line.commands.begin(),
      {access_commands(),   access_add_command(),   access_list_command(), access_revoke_command(),
       base_command(),      bridge_check_command(), calibrate_command(),   compensate_command(),
       doctor_command(),    drift_command(),        experiment_command(),  export_command(),
       fk_command(),        iso9283_command(),      kuka_commands(),       kuka_write_command(),
       kuka_lint_command(), listen_command(),       plan_command(),        positioner_command(),
       replay_command(),    restore_command(),      robot_commands(),      robot_fix_command(),
       tls_commands(),      tls_init_command(),     tls_client_command(),  tool_command()});
  line.commands.push_back(audit_verify_command());  // behind its group, which is the daemon's
  return run_command_line(line, {argv + 1, argv + argc});
}
