#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// The sections of the page with errors per point and how they are spread; empty where the document has no
/// points.
std::string chart_sections(const ReportDocument& document);

}  // namespace truepose::report
