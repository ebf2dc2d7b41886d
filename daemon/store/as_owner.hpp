#pragma once

#include <sys/types.h>

#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace truepose::daemon {

/// While it lives, root acts as the owner of a folder, usually the daemon's user. New files belong to that
/// user, and a link to a file of root's does no harm. Other users act as themselves.
class AsOwnerOf {
 public:
  /// The error is one sentence.
  static std::expected<AsOwnerOf, std::string> take(const std::filesystem::path& folder);
  AsOwnerOf(AsOwnerOf&& other) noexcept;
  AsOwnerOf& operator=(AsOwnerOf&&) = delete;
  /// Root again: the leak sanitizer cannot trace a process that has given root up.
  ~AsOwnerOf();

 private:
  AsOwnerOf() = default;

  std::optional<std::vector<gid_t>> groups_;  ///< that root had; none: nothing was changed
  gid_t group_ = 0;
};

}  // namespace truepose::daemon
