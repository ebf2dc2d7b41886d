#include "drivers/port_holder.hpp"

#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <system_error>

namespace truepose::drivers {
namespace {

struct Socket {
  std::string inode;
  std::string uid;
};

/// Finds the socket that owns a port in one of the kernel's tables (proc(5), /proc/net/tcp).
std::optional<Socket> find_socket(const char* table, std::uint16_t port, bool listening_only) {
  std::ifstream file{table};
  std::string line;
  std::getline(file, line);  // header
  while (std::getline(file, line)) {
    std::istringstream fields{line};
    std::string slot, local, remote, state, queues, timer, retransmits, uid, timeout, inode;
    fields >> slot >> local >> remote >> state >> queues >> timer >> retransmits >> uid >> timeout >> inode;
    const auto colon = local.rfind(':');
    if (!fields || colon == std::string::npos) continue;
    unsigned local_port = 0;
    std::from_chars(local.data() + colon + 1, local.data() + local.size(), local_port, 16);
    const bool listening = state == "0A";
    if (local_port == port && (listening || !listening_only)) return Socket{inode, uid};
  }
  return std::nullopt;
}

std::optional<Socket> find_socket(Protocol protocol, std::uint16_t port) {
  const bool tcp = protocol == Protocol::Tcp;
  auto socket = find_socket(tcp ? "/proc/net/tcp" : "/proc/net/udp", port, tcp);
  return socket ? socket : find_socket(tcp ? "/proc/net/tcp6" : "/proc/net/udp6", port, tcp);
}

/// Name and number of the process that has the socket open; only those of our own user can be seen into.
std::optional<std::string> find_process(const std::string& inode) {
  namespace fs = std::filesystem;
  const std::string wanted = "socket:[" + inode + "]";
  const fs::directory_iterator end;
  std::error_code gone;  // processes and their files vanish while we look
  for (fs::directory_iterator process{"/proc", gone}; process != end; process.increment(gone)) {
    const std::string pid = process->path().filename();
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    for (fs::directory_iterator fd{process->path() / "fd", gone}; fd != end; fd.increment(gone)) {
      if (fs::read_symlink(fd->path(), gone) != wanted) continue;
      std::string name;
      std::ifstream comm{process->path() / "comm"};
      std::getline(comm, name);
      return name + " (process " + pid + ")";
    }
  }
  return std::nullopt;
}

}  // namespace

std::string port_holder(Protocol protocol, std::uint16_t port) {
  const auto socket = find_socket(protocol, port);
  if (!socket) return "an unknown process";
  if (const auto process = find_process(socket->inode)) return *process;
  // We may look into these, so the one that had it is gone from the table of processes, or was never in
  // ours.
  if (::geteuid() == 0 || socket->uid == std::to_string(::geteuid()))
    return "a process of uid " + socket->uid + " that is just ending, or runs in another container";
  return "another user's process (uid " + socket->uid + ")";
}

bool is_held(Protocol protocol, std::uint16_t port) { return find_socket(protocol, port).has_value(); }

}  // namespace truepose::drivers
