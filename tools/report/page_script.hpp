#pragma once

#include <string_view>

namespace truepose::report {

/// The page's script: turns the clouds by dragging, and hands out embedded files as blobs, because browsers
/// limit the length of a link. Without it the page lacks nothing else. Holds no '<' or '&', so that the page
/// stays well-formed XML.
extern const std::string_view kPageScript;

}  // namespace truepose::report
