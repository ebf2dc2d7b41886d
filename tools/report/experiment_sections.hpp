#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::report {

/// The sections of an experiment document, as `truepose experiment --json` prints it, below a title of their
/// own.
/// Throws boost::system::system_error where a member is missing or of the wrong kind.
std::string experiment_sections(const boost::json::object& document);

}  // namespace truepose::report
