#pragma once

#include <expected>
#include <filesystem>
#include <string>

namespace truepose::daemon {

/// Puts a backup, or any copy of a store, in the place of a cell's store: while no daemon has that, after the
/// copy was checked, in one step, so that there is the old one or the new one and never a half of either. The
/// stream is not armed in it, whatever it was when the backup was made.
///
/// @param time  for the name of what was there, such as 20261124T235959Z
/// @return where the store that was there lies now, empty where there was none; or one sentence
std::expected<std::filesystem::path, std::string> restore_store(const std::filesystem::path& backup,
                                                                const std::filesystem::path& store,
                                                                const std::string& time);

}  // namespace truepose::daemon
