#include "daemon/recorder/folder_access.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace truepose::daemon {

std::string why_not_writable(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) return error ? error.message() : std::strerror(ENOTDIR);
  return ::access(folder.c_str(), W_OK | X_OK) == 0 ? "" : std::strerror(errno);
}

}  // namespace truepose::daemon
