#pragma once

#include <optional>
#include <string>

#include "proto/control/access.hpp"

namespace truepose::daemon {

/// Whose session it is.
struct Caller {
  std::string
      name;  ///< of the access file, kTokenFileName, or kLocalUserStart and the user over the Unix socket
  control::Role role = control::Role::Viewer;
  std::optional<control::AccessEntry> entry{};  ///< that let it in, where one did
};

}  // namespace truepose::daemon
