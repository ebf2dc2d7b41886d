#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/temp_folder.hpp"

namespace truepose::sim {

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{in}, {}};
}

/// truepose-sim as its users start it. Killed if it is still there at the end.
class SimulatorProcess {
 public:
  SimulatorProcess(const TempFolder& folder, std::vector<std::string> arguments)
      : output_{folder.path() / "stdout"}, errors_{folder.path() / "stderr"} {
    arguments.insert(arguments.begin(), TRUEPOSE_BIN_DIR "/truepose-sim");
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output_.c_str(), O_CREAT | O_WRONLY, 0600);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, errors_.c_str(), O_CREAT | O_WRONLY, 0600);
    const int failed = posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (failed) throw std::runtime_error{"truepose-sim cannot be started"};
  }

  ~SimulatorProcess() {
    if (ended()) return;
    kill(pid_, SIGKILL);
    wait();
  }
  SimulatorProcess(const SimulatorProcess&) = delete;
  SimulatorProcess& operator=(const SimulatorProcess&) = delete;

  /// The ready file's text, or nothing if the simulator ended instead of writing it.
  std::string ready(const std::filesystem::path& file) {
    while (!std::filesystem::exists(file)) {
      if (ended()) return {};
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
    return text_of(file);
  }

  void terminate() { kill(pid_, SIGTERM); }

  /// @return the exit code, or -1 if a signal ended it
  int wait() {
    if (!reaped_) waitpid(pid_, &status_, 0);
    reaped_ = true;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
  }

  std::string output() const { return text_of(output_); }
  std::string errors() const { return text_of(errors_); }

 private:
  bool ended() {
    if (!reaped_) reaped_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return reaped_;
  }

  std::filesystem::path output_, errors_;
  pid_t pid_ = 0;
  int status_ = 0;
  bool reaped_ = false;
};

}  // namespace truepose::sim
