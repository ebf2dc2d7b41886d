#include "daemon/control/token_file.hpp"

#include <fstream>
#include <iterator>

namespace truepose::daemon {

std::expected<std::string, std::string> read_token(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  constexpr std::size_t kShortest = 16;
  constexpr std::size_t kLongest = 1024;
  const auto bad = [&](const std::string& why) {
    return std::unexpected("token file " + file.string() + ": " + why);
  };

  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status))
    return bad("does not exist; make one with: (umask 077; openssl rand -hex 16 > " + file.string() + ")");
  if (!fs::is_regular_file(status)) return bad("is not a file");
  if ((status.permissions() & (fs::perms::group_all | fs::perms::others_all)) != fs::perms::none)
    return bad("others may read or write it; run: chmod 600 " + file.string());

  std::ifstream stream{file, std::ios::binary};
  std::string token;
  token.resize(kLongest + 1);
  stream.read(token.data(), static_cast<std::streamsize>(token.size()));
  if (stream.bad() || !stream.is_open()) return bad("cannot be read");
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
