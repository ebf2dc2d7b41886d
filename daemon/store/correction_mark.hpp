#pragma once

#include <filesystem>

#include "daemon/store/store_error.hpp"

namespace truepose::daemon {

// A file in the store's folder. From the first start or arming of the stream on it says that the controller
// may have a correction in effect. The runtime folder ends with the machine, a simulator that waits for a
// reply does not.

/// @return true as well where that cannot be found out
bool may_have_corrected(const std::filesystem::path& store) noexcept;

/// Durable when it returns; written once. An empty path is a store in memory, which leaves nothing. Error:
/// what failed, with the file.
StoreResult<void> keep_corrected(const std::filesystem::path& store);

}  // namespace truepose::daemon
