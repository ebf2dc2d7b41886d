#include "tests/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/await.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

constexpr int kPatience_ms = 120'000;

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{in}, {}};
}

Process::Process(const std::filesystem::path& folder, const std::string& name,
                 std::vector<std::string> arguments, std::vector<std::string> environment)
    : output_{folder / std::filesystem::path{name + ".out"}.filename()},
      errors_{folder / std::filesystem::path{name + ".err"}.filename()} {
  arguments.insert(arguments.begin(), std::filesystem::path{TRUEPOSE_BIN_DIR} / name);
  for (char** variable = environ; *variable != nullptr; ++variable) environment.emplace_back(*variable);
  const std::vector<char*> argv = pointers(arguments), envp = pointers(environment);

  constexpr int kNew = O_CREAT | O_WRONLY | O_TRUNC;
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output_.c_str(), kNew, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, errors_.c_str(), kNew, 0600);
  // A port that the test holds open is the test's alone.
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  const int failed = posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&files);
  if (failed != 0) throw std::runtime_error{name + " cannot be started"};
  // glibc 2.36 declares pidfd_open() for C alone.
  descriptor_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
}

Process::~Process() {
  if (!ended()) {
    send(SIGKILL);
    wait();
  }
  close(descriptor_);
}

void Process::send(int signal) const {
  if (!reaped_) kill(pid_, signal);
}

void Process::terminate() const { send(SIGTERM); }

bool Process::ended() {
  if (!reaped_) reaped_ = waitpid(pid_, &status_, WNOHANG) == pid_;
  return reaped_;
}

std::string Process::ready(const std::filesystem::path& file) {
  await(file.string() + " is written", [&] { return std::filesystem::exists(file) || ended(); });
  return text_of(file);
}

int Process::wait() {
  if (!reaped_) {
    pollfd end{.fd = descriptor_, .events = POLLIN, .revents = 0};
    if (poll(&end, 1, kPatience_ms) == 0) send(SIGKILL);
    waitpid(pid_, &status_, 0);
    reaped_ = true;
  }
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
}

bool Process::wait_readable(int descriptor) {
  std::array<pollfd, 2> watched{pollfd{.fd = descriptor, .events = POLLIN, .revents = 0},
                                pollfd{.fd = descriptor_, .events = POLLIN, .revents = 0}};
  poll(watched.data(), watched.size(), kPatience_ms);
  return (watched[0].revents & POLLIN) != 0;
}

Finished run_program(const std::string& name, const std::vector<std::string>& arguments) {
  const TempFolder folder;
  Process program{folder.path(), name, arguments};
  const int exit_code = program.wait();
  return {.exit_code = exit_code, .out = program.output(), .err = program.errors()};
}

Finished run_into_one_file(const std::string& name, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{"-c", "exec \"$0\" \"$@\" 2>&1",
                                 std::filesystem::path{TRUEPOSE_BIN_DIR} / name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return run_program("/bin/sh", words);
}

}  // namespace truepose
