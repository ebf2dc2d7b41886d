#pragma once

#include <sys/types.h>

#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace truepose::daemon {

/// While it lives, root acts as the user to whom a folder belongs, as the daemon's user: what is made there
/// is his, and what he may have put there, as a link to a file of root's, does no harm. Others act as
/// themselves.
class AsOwnerOf {
 public:
  /// The error is one sentence.
  static std::expected<AsOwnerOf, std::string> take(const std::filesystem::path& folder);
  AsOwnerOf(AsOwnerOf&& other) noexcept;
  AsOwnerOf& operator=(AsOwnerOf&&) = delete;
  /// Root again: nobody traces a process that gave root up, not even the leak sanitizer its own.
  ~AsOwnerOf();

 private:
  AsOwnerOf() = default;

  std::optional<std::vector<gid_t>> groups_;  ///< that root had; none: nothing was changed
  gid_t group_ = 0;
};

}  // namespace truepose::daemon
