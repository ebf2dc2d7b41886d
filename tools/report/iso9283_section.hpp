#pragma once

#include <boost/json/fwd.hpp>
#include <string>
#include <vector>

#include "tools/report/raw_data.hpp"

namespace truepose::report {

/// The section of an ISO 9283 document, as `truepose iso9283 --json` prints it.
/// Throws boost::system::system_error where a member is missing or of the wrong kind.
std::string iso9283_section(const boost::json::object& document);

/// The same as a page of its own (well-formed XML, no external file), which carries the document for
/// download.
///
/// @param data_file  which was evaluated
/// @param files      what it was evaluated from, for download too
std::string render_iso9283_html(const boost::json::object& document, const std::string& data_file,
                                std::vector<EmbeddedFile> files);

}  // namespace truepose::report
