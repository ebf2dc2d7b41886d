#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

/// One report in its three forms.
struct RenderedReport {
  std::string html, table;
  boost::json::object document;
};

/// Writes the files that the options ask for, all of them or none, and prints the table or the document.
/// Throws ConfigError where a file cannot be written.
void deliver(const RenderedReport& report, const ReportOptions& options, bool as_json);

}  // namespace truepose::tools
