#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace truepose {

/// The whole text of a file; empty where there is none.
std::string text_of(const std::filesystem::path& file);

/// A program of ours from the build's bin folder, started as its users start it, or any other by its absolute
/// path. Killed if it is still there at the end.
class Process {
 public:
  /// @param folder       keeps what it says, in NAME.out and NAME.err; outlives the process
  /// @param environment  "NAME=value" each, in addition to our own
  Process(const std::filesystem::path& folder, const std::string& name, std::vector<std::string> arguments,
          std::vector<std::string> environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void send(int signal) const;
  void terminate() const;  ///< SIGTERM

  bool ended();
  /// Waits for the file that it writes once it is ready. @return its text; empty where it ended without
  std::string ready(const std::filesystem::path& file);
  /// Waits for the end; a program that takes more than two minutes for it is killed.
  /// @return the exit code, or -1 if a signal ended it
  int wait();

  /// Waits until a file descriptor can be read.
  /// @return false where the program ended, or two minutes passed, before
  bool wait_readable(int descriptor);

  std::string output() const { return text_of(output_); }
  std::string errors() const { return text_of(errors_); }

 private:
  std::filesystem::path output_, errors_;
  pid_t pid_ = 0;
  int descriptor_ = -1;  // readable once the program has ended
  int status_ = 0;
  bool reaped_ = false;
};

/// What a program said and how it ended.
struct Finished {
  int exit_code = -1;  ///< -1 where a signal ended it
  std::string out, err;
};

/// Runs a program to its end.
Finished run_program(const std::string& name, const std::vector<std::string>& arguments);

/// The same with all that it says in `out`, as it comes.
Finished run_into_one_file(const std::string& name, const std::vector<std::string>& arguments);

}  // namespace truepose
