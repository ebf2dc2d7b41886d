#include "tools/sim/whole_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>

namespace truepose::sim {

void write_whole(const std::filesystem::path& file, std::string_view text) {
  const std::filesystem::path unfinished = file.string() + "." + std::to_string(getpid());
  std::ofstream out{unfinished, std::ios::binary};
  out << text << '\n';
  out.close();
  if (!out) throw std::system_error{errno, std::generic_category(), file.string()};
  std::filesystem::rename(unfinished, file);
}

}  // namespace truepose::sim
