#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::report {

/// The table of errors before and after each stage for a terminal, with the verdict below it, ending in a
/// newline.
///
/// @param document  as for render_html; throws like it
std::string render_text(const boost::json::object& document);

/// Why a calibration must not be used, a clause; empty: nothing is against it. Whoever ends with an exit code
/// asks this.
///
/// @param document  as for render_html; throws like it
std::string why_unusable(const boost::json::object& document);

}  // namespace truepose::report
