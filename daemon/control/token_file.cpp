#include "daemon/control/token_file.hpp"

#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

namespace truepose::daemon {

namespace {

bool too_open(const struct stat& file) {
  const bool for_our_group = file.st_gid == ::getegid();
  const mode_t forbidden = for_our_group ? (S_IWGRP | S_IXGRP | S_IRWXO) : (S_IRWXG | S_IRWXO);
  return (file.st_mode & forbidden) != 0;
}

/// What makes a file ours to read, and nobody else's: one that is another's has to be given to our group.
std::string mending(const struct stat& found, const std::string& file) {
  if (found.st_uid == ::geteuid()) return "; run: chmod 600 " + file;
  const struct group* const ours = ::getgrgid(::getegid());
  return "; run: chgrp " + (ours ? std::string{ours->gr_name} : std::to_string(::getegid())) + " " + file +
         " && chmod 640 " + file;
}

}  // namespace

std::expected<std::string, std::string> read_token(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  constexpr std::size_t kShortest = 16;
  constexpr std::size_t kLongest = 1024;
  const auto bad = [&](const std::string& why) {
    return std::unexpected("token file " + file.string() + ": " + why);
  };

  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) {
    if (errno != ENOENT) return bad(std::strerror(errno));
    return bad("does not exist; make one with: (umask 077; openssl rand -hex 16 > " + file.string() + ")");
  }
  if (!S_ISREG(found.st_mode)) return bad("is not a file");
  if (too_open(found)) return bad("others may read or write it" + mending(found, file.string()));

  std::ifstream stream{file, std::ios::binary};
  std::string token;
  token.resize(kLongest + 1);
  stream.read(token.data(), static_cast<std::streamsize>(token.size()));
  if (stream.bad() || !stream.is_open()) return bad("cannot be read" + mending(found, file.string()));
  token.resize(static_cast<std::size_t>(stream.gcount()));
  constexpr std::string_view kSpace = " \t\r\n";
  token.erase(token.find_last_not_of(kSpace) + 1);
  token.erase(0, token.find_first_not_of(kSpace));
  if (token.size() < kShortest || token.size() > kLongest)
    return bad("the token must have " + std::to_string(kShortest) + ".." + std::to_string(kLongest) +
               " characters");
  return token;
}

bool same_token(std::string_view given, std::string_view secret) {
  volatile unsigned difference = given.size() == secret.size() ? 0 : 1;
  for (std::size_t i = 0; i < given.size(); ++i)
    difference = difference | static_cast<unsigned>(given[i] ^ secret[i % secret.size()]);
  return difference == 0;
}

}  // namespace truepose::daemon
