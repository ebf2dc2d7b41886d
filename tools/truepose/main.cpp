#include <malloc.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "tools/truepose/cell/cell_commands.hpp"
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

/// The experiments are a program of their own in the same folder, which is built but not installed.
int run_experiment(char** arguments) {
  const auto program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("truepose-experiment");
  execv(program.c_str(), arguments);
  std::fprintf(stderr, "truepose: experiment: %s cannot be run. Build truepose from its sources.\n",
               program.c_str());
  return truepose::tools::kBadInput;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace truepose::tools;
  if (argc > 1 && std::string_view{argv[1]} == "experiment") return run_experiment(argv + 1);
  keep_freed_memory();
  CommandLine line = online_commands();
  line.commands.insert(
      line.commands.begin(),
      {access_commands(),      access_add_command(),   access_list_command(),  access_revoke_command(),
       base_command(),         bridge_check_command(), calibrate_command(),    cell_commands(),
       cell_demo_command(),    cell_new_command(),     compensate_command(),   data_commands(),
       data_check_command(),   doctor_command(),       drift_command(),        export_command(),
       fk_command(),           iso9283_command(),      kuka_commands(),        kuka_write_command(),
       kuka_lint_command(),    listen_command(),       plan_command(),         positioner_command(),
       replay_command(),       restore_command(),      robot_commands(),       robot_check_command(),
       robot_export_command(), robot_fix_command(),    robot_import_command(), robot_list_command(),
       robot_new_command(),    robot_show_command(),   tls_commands(),         tls_init_command(),
       tls_client_command(),   tool_command()});
  line.commands.push_back(audit_verify_command());  // behind its group, which is the daemon's
  return run_command_line(line, {argv + 1, argv + argc});
}
