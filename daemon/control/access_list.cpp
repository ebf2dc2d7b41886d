#include "daemon/control/access_list.hpp"

#include <utility>

#include "daemon/control/private_file.hpp"

namespace truepose::daemon {

std::filesystem::path access_file_of(const std::filesystem::path& store) {
  std::filesystem::path file = store;
  file += ".access";
  return file;
}

std::expected<control::AccessEntries, std::string> read_access_file(const std::filesystem::path& file) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20U;
  std::error_code unknown;
  if (!std::filesystem::exists(file, unknown) && !unknown) return control::AccessEntries{};
  const auto bad = [&](const std::string& why) {
    return std::unexpected("access file " + file.string() + ": " + why);
  };
  const auto text = read_private_file(file, kMostBytes);
  if (!text) return bad(text.error());
  auto access = control::read_access(*text);
  if (!access) return bad(access.error());
  return *std::move(access);
}

std::expected<bool, std::string> AccessList::refresh() {
  const FileStamp stamp = stamp_of(file_);
  if (stamp == stamp_) return false;
  auto entries = read_access_file(file_);
  if (!entries) {
    // A failure may pass while the file stays the same: it is read again, and reported once.
    if (std::exchange(complaint_, entries.error()) == entries.error()) return false;
    return std::unexpected(entries.error());
  }
  stamp_ = stamp;
  complaint_.clear();
  entries_ = *std::move(entries);
  return true;
}

}  // namespace truepose::daemon
