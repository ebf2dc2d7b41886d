#pragma once

#include <expected>
#include <string>

namespace truepose::daemon {

struct StoreError {
  std::string detail;     ///< what SQLite said, in which operation, on which file
  bool may_pass = false;  ///< waiting may help: a full disk, one that fails for a moment, a file that
                          ///< another connection writes
};
template <typename T>
using StoreResult = std::expected<T, StoreError>;

}  // namespace truepose::daemon
