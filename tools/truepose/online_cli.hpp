#pragma once

namespace CLI {
class App;
}

namespace truepose::tools {

/// Adds the commands that talk to the daemon. The command that was chosen runs while `app` parses and leaves
/// its exit code in `exit_code`. Call once.
void add_online_commands(CLI::App& app, int& exit_code);

}  // namespace truepose::tools
