#include "daemon/control/private_file.hpp"

#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace truepose::daemon {

namespace {

bool too_open(const struct stat& file) {
  // Root gives its own file to the group of the service, as the package does with the token.
  const bool of_root = file.st_uid == 0 && ::geteuid() == 0;
  const bool for_our_group = of_root || file.st_gid == ::getegid();
  const mode_t forbidden = for_our_group ? (S_IWGRP | S_IXGRP | S_IRWXO) : (S_IRWXG | S_IRWXO);
  return (file.st_mode & forbidden) != 0;
}

/// What makes a file ours to read, and nobody else's: one that is another's has to be given to our group.
std::string fix_command(const struct stat& found, const std::string& file) {
  if (found.st_uid == ::geteuid()) return "; run: chmod 600 " + file;
  const struct group* const ours = ::getgrgid(::getegid());
  return "; run: chgrp " + (ours ? std::string{ours->gr_name} : std::to_string(::getegid())) + " " + file +
         " && chmod 640 " + file;
}

}  // namespace

std::expected<std::string, std::string> read_private_file(const std::filesystem::path& file,
                                                          std::size_t most) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return std::unexpected(std::strerror(errno));
  if (!S_ISREG(found.st_mode)) return std::unexpected("is not a file");
  if (too_open(found))
    return std::unexpected("others may read or write it" + fix_command(found, file.string()));
  errno = 0;
  std::ifstream stream{file, std::ios::binary};
  std::string text(most, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || !stream.is_open()) {
    const int code = errno;
    const std::string why = code == 0 ? "" : std::string{": "} + std::strerror(code);
    return std::unexpected("cannot be read" + why +
                           (code == EACCES ? fix_command(found, file.string()) : ""));
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

}  // namespace truepose::daemon
