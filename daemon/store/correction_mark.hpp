#pragma once

#include <filesystem>

#include "daemon/store/store_error.hpp"

namespace truepose::daemon {

// A file beside the store that says, from the first time on that its stream is started or armed, that the
// cell's controller may have a correction in force. The runtime folder ends with the machine, a simulator
// that waits for a reply does not.

/// @return true as well where that cannot be found out
bool may_have_corrected(const std::filesystem::path& store) noexcept;

/// Durable when it returns; written once. An empty path is a store in memory, which leaves nothing. Error:
/// what failed, with the file.
StoreResult<void> keep_corrected(const std::filesystem::path& store);

}  // namespace truepose::daemon
