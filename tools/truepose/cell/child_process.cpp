#include "tools/truepose/cell/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <system_error>

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;

/// Of the program that runs; where /proc is not mounted the one of the packages.
fs::path own_folder() {
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed);
  return failed ? "/usr/bin" : program.parent_path();
}

constexpr int kNotStarted = 127;

/// In the child: what the parent set up, then the program.
[[noreturn]] void become(const fs::path& program, std::vector<char*>& words, const fs::path& log) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (!log.empty()) {
    const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file < 0 || ::dup2(file, STDOUT_FILENO) < 0 || ::dup2(file, STDERR_FILENO) < 0) ::_exit(kNotStarted);
  }
  ::execv(program.c_str(), words.data());
  ::_exit(kNotStarted);
}

}  // namespace

fs::path installed_program(const std::string& name, const std::string& package) {
  std::vector<fs::path> folders{own_folder()};
  const char* const path = std::getenv("PATH");
  std::istringstream entries{path ? path : ""};
  for (std::string folder; std::getline(entries, folder, ':');) folders.emplace_back(folder);
  for (const fs::path& folder : folders)
    if (::access((folder / name).c_str(), X_OK) == 0) return folder / name;
  throw CommandError{kBadInput, name + ": not found in " + folders.front().string() +
                                    " or in PATH. Install the package " + package + "."};
}

fs::path installed_data() { return own_folder().parent_path() / "share/truepose"; }

ChildProcess::ChildProcess(const fs::path& program, const std::vector<std::string>& arguments,
                           const fs::path& log) {
  std::vector<std::string> texts{program.string()};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& text : texts) words.push_back(text.data());
  words.push_back(nullptr);
  flush_standard_output();  // else both would print what is buffered
  pid_ = ::fork();
  if (pid_ < 0) throw CommandError{kFailed, program.string() + ": not started: " + std::strerror(errno)};
  if (pid_ == 0) become(program, words, log);
}

ChildProcess::~ChildProcess() {
  if (!reaped_) terminate();
}

bool ChildProcess::ended() {
  if (!reaped_) reaped_ = ::waitpid(pid_, &status_, WNOHANG) == pid_;
  return reaped_;
}

int ChildProcess::wait() {
  while (!reaped_) reaped_ = ::waitpid(pid_, &status_, 0) == pid_;
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : static_cast<int>(kFailed);
}

int ChildProcess::terminate() {
  if (!ended()) ::kill(pid_, SIGTERM);
  return wait();
}

int run_program(const fs::path& program, const std::vector<std::string>& arguments) {
  return ChildProcess{program, arguments}.wait();
}

}  // namespace truepose::tools
