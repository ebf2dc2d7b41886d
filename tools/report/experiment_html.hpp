#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::report {

/// One self-contained HTML page (well-formed XML, no external file) of an experiment document, as
/// `truepose experiment --json` prints it.
/// Throws boost::system::system_error where a member is missing or of the wrong kind.
std::string render_experiment_html(const boost::json::object& document);

}  // namespace truepose::report
