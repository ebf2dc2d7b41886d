#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// The sections of the page that are tables. Each is empty where the document has nothing for it.
std::string statistics_section(const ReportDocument& document);
std::string parameters_section(const ReportDocument& document);

}  // namespace truepose::report
