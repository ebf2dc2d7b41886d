#include <algorithm>
#include <cstdio>
#include <memory>
#include <sstream>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "config/robot_fix.hpp"
#include "config/text_file.hpp"
#include "core/diagnosis/model_sanity.hpp"
#include "core/math/parallel.hpp"
#include "tools/truepose/offline/mistake_text.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/progress_line.hpp"

namespace truepose::tools {
namespace {

struct RobotFix {
  std::string robot_file, data_file, out_file, out_data_file;
  TableOptions table;
  int take = 0;  ///< of the corrections that fit equally, from 1; 0: none is chosen
};

bool is_in(MistakenFile file, const ProbableCause& cause) {
  return std::ranges::any_of(cause.mistakes, [&](const Mistake& each) { return each.file == file; });
}

std::string measurements_text(const MeasurementData& data, const RobotModel& robot) {
  std::ostringstream text;
  config::write_measurements(text, data, robot);
  return text.str();
}

/// The fixed files to write.
std::vector<config::TextFile> fixed_files(const RobotFix& command, const ProbableCause& cause,
                                          const MeasurementData& data) {
  const std::string mistake = mistake_text(cause, command.robot_file, command.data_file);
  std::vector<config::TextFile> files;
  if (is_in(MistakenFile::Robot, cause)) {
    if (command.out_file.empty()) throw CommandError{kFailed, mistake + " where --out says"};
    files.push_back({command.out_file, config::fixed_robot_text(command.robot_file, cause.fixed_arm)});
  }
  if (is_in(MistakenFile::Measurements, cause)) {
    if (command.out_data_file.empty()) throw CommandError{kFailed, mistake + " where --out-data says"};
    files.push_back(
        {command.out_data_file, measurements_text({data.smr_names, cause.fixed_points}, cause.fixed_arm)});
  }
  return files;
}

/// The corrections that fit equally: "(1) joint 1 ..; (2) alpha of joint 2 ..".
std::string choices(const ProbableCause& cause) {
  std::string text = "(1) " + cause.sentence;
  for (std::size_t k = 0; k < cause.others.size(); ++k)
    text += "; (" + std::to_string(k + 2) + ") " + cause.others[k].sentence;
  return text;
}

/// The correction that is to be written. Throws CommandError where several fit equally and none is chosen.
const ProbableCause& chosen(const RobotFix& command, const ProbableCause& cause) {
  const std::size_t count = cause.others.size() + 1;
  const auto take = static_cast<std::size_t>(command.take);
  if (take > count)
    throw CommandError{
        kFailed, "--take " + std::to_string(take) + ": there " +
                     (count == 1 ? "is 1 correction" : "are " + std::to_string(count) + " corrections") +
                     ": no file was written"};
  if (take > 1) return cause.others[take - 2];
  if (take == 1 || count == 1) return cause;
  throw CommandError{kFailed, command.robot_file + ": " + std::to_string(count) +
                                  " corrections fit equally: " + choices(cause) +
                                  ". No file was written. Choose one: --take 1 .. --take " +
                                  std::to_string(count)};
}

int run_fix(const RobotFix& command) {
  const RobotModel robot = config::load_robot(command.robot_file);
  const config::TableReading reading = reading_of(command.table);
  const MeasurementData data = config::load_measurements(command.data_file, robot, &reading);
  const auto cause = [&] {
    const ProgressLine line{"diagnosis"};
    return diagnose_files(robot, data, processor_count());
  }();
  if (!cause)
    throw CommandError{kFailed, command.robot_file + ": nothing to correct, as far as " + command.data_file +
                                    " shows: no file was written"};
  if (cause->mistakes.empty())
    throw CommandError{kFailed, mistake_text(*cause, command.robot_file, command.data_file)};
  const ProbableCause& correction = chosen(command, *cause);
  if (std::ranges::any_of(correction.mistakes, &Mistake::needs_manual_fix))
    throw CommandError{
        kFailed, mistake_text(correction, command.robot_file, command.data_file) + ": no file was written"};
  const auto files = fixed_files(command, correction, data);
  config::write_together(files);
  std::printf("%s\n", correction.sentence.c_str());
  for (const config::TextFile& file : files) std::printf("%s: written\n", file.path.c_str());
  return kDone;
}

}  // namespace

Command robot_commands() { return {.name = "robot", .help = "The robot file"}; }

Command robot_fix_command() {
  const auto command = std::make_shared<RobotFix>();
  RobotFix& c = *command;
  return {.name = "robot fix",
          .help = "Finds what is wrong in a robot file or its measurements, and writes them corrected",
          .options = {Option("robot", &c.robot_file, "Robot file (YAML)",
                             {.required = true, .type = "ROBOT", .file = FileUse::Read}),
                      Option("measurements", &c.data_file, "Measurements (CSV)",
                             {.required = true, .type = "MEASUREMENTS", .file = FileUse::Read}),
                      Option("--out", &c.out_file,
                             "The corrected robot file; all but the corrected numbers stays as it is",
                             {.file = FileUse::Written}),
                      Option("--out-data", &c.out_data_file,
                             "The corrected measurements, where the mistake is in them",
                             {.file = FileUse::Written}),
                      Option("--take", &c.take, "Which of several corrections that fit equally to write",
                             {.check = in_range(1, 1000)}),
                      columns_option(c.table), units_option(c.table)},
          .run = [command] { return run_fix(*command); },
          .examples = {{"robot fix arm.yaml points.csv -o fixed.yaml",
                        "Write the robot file that agrees with the measurements"}}};
}

}  // namespace truepose::tools
