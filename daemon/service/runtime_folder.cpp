#include "daemon/service/runtime_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace truepose::daemon {

namespace {

namespace fs = std::filesystem;

std::string from_environment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

/// The cell's name as the name of one folder.
std::string folder_name(std::string name) {
  for (char& letter : name) {
    const bool plain = (letter >= '0' && letter <= '9') || (letter >= 'a' && letter <= 'z') ||
                       (letter >= 'A' && letter <= 'Z') || letter == '-' || letter == '_';
    if (!plain) letter = '-';
  }
  return name;
}

fs::path chosen_folder(const config::CellConfig& config, const RuntimePlaces& places) {
  if (!config.runtime.empty()) return config.runtime;
  // A unit may have several, separated by colons: the first is the cell's.
  if (!places.unit.empty()) return places.unit.substr(0, places.unit.find(':'));
  const std::string name = folder_name(config.name);
  if (!places.user.empty()) return places.user / ("truepose-" + name);
  return places.system / name;
}

}  // namespace

RuntimePlaces RuntimePlaces::of_environment() {
  return {.unit = from_environment("RUNTIME_DIRECTORY"), .user = from_environment("XDG_RUNTIME_DIR")};
}

std::expected<fs::path, std::string> runtime_folder(const config::CellConfig& config,
                                                    const RuntimePlaces& places) {
  const fs::path folder = chosen_folder(config, places);
  const auto bad = [&](const std::string& why) {
    return std::unexpected("runtime folder " + folder.string() + ": " + why +
                           "; name another with the cell file's key runtime");
  };
  std::error_code error;
  fs::create_directories(folder.parent_path(), error);
  // Made with its mode: nobody may slip in before it is set.
  if (!error && ::mkdir(folder.c_str(), 0750) != 0 && errno != EEXIST)
    error = {errno, std::system_category()};
  if (error) return bad("cannot be made (" + error.message() + ")");

  struct stat found {};
  if (::lstat(folder.c_str(), &found) != 0) return bad(std::strerror(errno));
  if (!S_ISDIR(found.st_mode)) return bad("is no folder");
  // Whoever else may write there could put a control socket of his own in place of ours.
  if (found.st_uid != ::geteuid()) return bad("belongs to another user");
  if ((found.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    return bad("others may write there; run: chmod 750 " + folder.string());
  return folder;
}

}  // namespace truepose::daemon
