#include "tests/integration/own_network.hpp"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "tests/process.hpp"

namespace truepose {
namespace {

constexpr const char* kIp = "/usr/sbin/ip";

int network_of_this_thread() { return ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC); }

void ip(const std::vector<std::string>& words) {
  const Finished done = run_program(kIp, words);
  if (done.exit_code != 0) throw std::runtime_error{done.err};
}

}  // namespace

OwnNetwork::OwnNetwork(const std::vector<std::string>& addresses) : before_{network_of_this_thread()} {
  if (before_ < 0 || ::unshare(CLONE_NEWNET) != 0) throw std::system_error{errno, std::generic_category()};
  ip({"link", "set", "lo", "up"});
  for (const std::string& address : addresses) ip({"address", "add", address + "/32", "dev", "lo"});
}

OwnNetwork::~OwnNetwork() {
  ::setns(before_, CLONE_NEWNET);
  ::close(before_);
}

bool OwnNetwork::possible() {
  if (!std::filesystem::exists(kIp)) return false;
  const int before = network_of_this_thread();
  const bool may = before >= 0 && ::unshare(CLONE_NEWNET) == 0;
  if (may) ::setns(before, CLONE_NEWNET);
  ::close(before);
  return may;
}

}  // namespace truepose
