#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace truepose::tools {

/// The program of this installation with this name: in the folder of the running one, else in PATH.
/// @param package  Debian package that has it, for the error
/// Throws CommandError (kBadInput) where it is in neither.
std::filesystem::path installed_program(const std::string& name, const std::string& package);

/// Folder of what is installed with the running program (share/truepose).
std::filesystem::path installed_data();

/// A program of ours. It is asked to end (SIGTERM) when this object, or the running program, ends.
class ChildProcess {
 public:
  /// @param log  file that gets what it prints; empty: it prints to where we do
  /// Throws CommandError (kFailed) where it cannot be started.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               const std::filesystem::path& log = {});
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool ended();
  /// Waits for its end. @return the exit code; kFailed where a signal ended it
  int wait();
  /// Asks it to end, and waits.
  int terminate();

 private:
  pid_t pid_ = 0;
  int status_ = 0;
  bool reaped_ = false;
};

/// Runs it to its end, printing to where we do. @return the exit code
int run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments);

}  // namespace truepose::tools
