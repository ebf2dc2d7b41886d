#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace truepose::tools {

// Each adds a subcommand that works on files alone. It writes its results to standard output and may throw
// ConfigError.

/// @param exit_code  set to kFailed where the identification did not converge or made things worse
void add_calibrate_command(CLI::App& app, int& exit_code);
/// @param exit_code  set to kFailed where the two-stage fit did not converge in every trial
void add_experiment_command(CLI::App& app, int& exit_code);
void add_export_command(CLI::App& app);
void add_fk_command(CLI::App& app);
void add_plan_command(CLI::App& app);
/// @param exit_code  set to kFailed where a target cannot be reached
void add_compensate_command(CLI::App& app, int& exit_code);
/// @param exit_code  set to kFailed where the model is no longer right
void add_drift_command(CLI::App& app, int& exit_code);
void add_iso9283_command(CLI::App& app);

/// Refuses a value that this version does not offer, and names those that it does.
CLI::Validator available(std::vector<std::string_view> values);

}  // namespace truepose::tools
