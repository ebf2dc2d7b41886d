#pragma once

#include <string>

namespace truepose::daemon {

/// What helps against a failed write: "make room on the disk".
/// @param error  as errno tells it
std::string disk_advice(int error);

}  // namespace truepose::daemon
