#pragma once

#include <boost/json/value.hpp>
#include <string>

namespace truepose::tools {

/// A drift document (proto/record/drift_document.hpp) for people: errors point by point, and the verdict.
std::string drift_text(const boost::json::value& document);

}  // namespace truepose::tools
