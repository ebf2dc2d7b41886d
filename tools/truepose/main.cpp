#include <malloc.h>

#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/online/online_commands.hpp"

namespace {

/// The matrices of a fit come and go by megabytes. Where freed memory goes back to the system, each of their
/// pages is a fault again.
void keep_freed_memory() {
  constexpr int kMebibyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMebibyte);
  mallopt(M_TRIM_THRESHOLD, 512 * kMebibyte);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace truepose::tools;
  keep_freed_memory();
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
