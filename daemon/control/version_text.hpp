#pragma once

#include <string>

namespace truepose::daemon {

/// "trueposed 0.1.0" and, in a second line, the libraries that it runs with: those that a report of a fault,
/// or of a flaw in one of them, is about.
std::string version_text(const std::string& program);

}  // namespace truepose::daemon
