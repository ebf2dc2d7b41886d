#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::report {

/// The page of an experiment document, as `truepose-experiment --json` prints it, which it carries for
/// download. HTML, one file.
/// Throws std::invalid_argument where a member is missing.
std::string render_experiment_html(const boost::json::object& document);

}  // namespace truepose::report
