#pragma once

#include <string>
#include <string_view>

namespace truepose::report {

/// One self-contained HTML page: well-formed XML, no external file.
///
/// @param title  plain text
/// @param body   what is in <main>, well-formed
std::string html_page(std::string_view title, std::string_view body);

/// The page's heading.
///
/// @param kind      what it is, "Calibration report"
/// @param title     plain text
/// @param identity  plain text below it, may be empty
std::string page_header(std::string_view kind, std::string_view title, std::string_view identity);

}  // namespace truepose::report
