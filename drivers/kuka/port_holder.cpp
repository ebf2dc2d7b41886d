#include "drivers/kuka/port_holder.hpp"

#include <charconv>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

namespace truepose::drivers {
namespace {

namespace fs = std::filesystem;

/// What /proc/PID/fd/N points to for every socket bound to the port.
std::set<std::string> sockets_of(std::uint16_t port) {
  std::set<std::string> sockets;
  for (const char* table : {"/proc/net/udp", "/proc/net/udp6"}) {
    std::ifstream file{table};
    std::string line;
    std::getline(file, line);  // the header
    while (std::getline(file, line)) {
      // sl local_address rem_address st tx_queue:rx_queue tr:tm->when retrnsmt uid timeout inode
      std::istringstream words{line};
      std::vector<std::string> columns;
      for (std::string word; columns.size() < 10 && words >> word;) columns.push_back(word);
      if (columns.size() < 10) continue;
      const std::string hex = columns[1].substr(columns[1].find(':') + 1);
      std::uint16_t bound = 0;
      std::from_chars(hex.data(), hex.data() + hex.size(), bound, 16);
      if (bound == port) sockets.insert("socket:[" + columns[9] + "]");
    }
  }
  return sockets;
}

bool holds(const fs::path& process, const std::set<std::string>& sockets) {
  std::error_code error;  // processes end, and others' are closed to us: both are skipped
  for (fs::directory_iterator entry{process / "fd", error}, end; !error && entry != end;
       entry.increment(error)) {
    std::error_code unreadable;
    if (sockets.contains(fs::read_symlink(entry->path(), unreadable).string())) return true;
  }
  return false;
}

}  // namespace

std::string udp_port_holder(std::uint16_t port) {
  const std::set<std::string> sockets = sockets_of(port);
  std::error_code error;
  for (fs::directory_iterator process{"/proc", error}, end; !error && process != end;
       process.increment(error)) {
    const std::string pid = process->path().filename();
    if (pid.find_first_not_of("0123456789") != std::string::npos || !holds(process->path(), sockets))
      continue;
    std::string name;
    std::getline(std::ifstream{process->path() / "comm"}, name);
    return " by " + name + " (pid " + pid + ")";
  }
  return {};
}

}  // namespace truepose::drivers
