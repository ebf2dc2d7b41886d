#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::report {

/// "200 trials · seed 0 · tracker 0.010 mm and repeatability 0.017 mm per axis": plain text.
std::string experiment_identity(const boost::json::object& document);

/// How near the two-stage fit comes to the Cramer-Rao bound, in large; empty where it never converged.
std::string experiment_summary(const boost::json::object& document);

/// The sections of an experiment document, as `truepose experiment --json` prints it, for a page that is
/// about something else too: they begin with a title of their own. Throws boost::system::system_error where a
/// member is missing or of the wrong kind.
std::string experiment_sections(const boost::json::object& document);

}  // namespace truepose::report
