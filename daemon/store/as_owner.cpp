#include "daemon/store/as_owner.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace truepose::daemon {

std::expected<AsOwnerOf, std::string> AsOwnerOf::take(const std::filesystem::path& folder) {
  AsOwnerOf owner;
  if (::geteuid() != 0) return owner;
  const auto failed = [&] { return std::unexpected(folder.string() + ": " + std::strerror(errno)); };
  struct stat found {};
  if (::stat(folder.c_str(), &found) != 0) return failed();
  const int count = ::getgroups(0, nullptr);
  std::vector<gid_t> groups(static_cast<std::size_t>(count < 0 ? 0 : count));
  if (count < 0 || ::getgroups(count, groups.data()) < 0) return failed();
  owner.group_ = ::getegid();
  if (::setgroups(1, &found.st_gid) != 0) return failed();  // as in a user namespace
  owner.groups_ = std::move(groups);
  if (::setegid(found.st_gid) != 0 || ::seteuid(found.st_uid) != 0) return failed();
  return owner;
}

AsOwnerOf::AsOwnerOf(AsOwnerOf&& other) noexcept
    : groups_{std::exchange(other.groups_, std::nullopt)}, group_{other.group_} {}

AsOwnerOf::~AsOwnerOf() {
  if (!groups_) return;
  if (::seteuid(0) != 0 || ::setegid(group_) != 0 || ::setgroups(groups_->size(), groups_->data()) != 0)
    std::abort();
}

}  // namespace truepose::daemon
