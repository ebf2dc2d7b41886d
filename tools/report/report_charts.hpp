#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// The sections of the page that are charts; empty where the document has no points.
std::string histogram_section(const ReportDocument& document);
std::string point_sections(const ReportDocument& document);

}  // namespace truepose::report
