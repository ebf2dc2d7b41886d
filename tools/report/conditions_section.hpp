#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// What was measured, with what, when and how; only what the document tells.
std::string conditions_section(const ReportDocument& document);

/// How far a pose that was measured now and then moved meanwhile; empty where none was.
std::string drift_section(const ReportDocument& document);

/// How the arm's stream of corrections went; empty where none ran.
std::string stream_section(const ReportDocument& document);

}  // namespace truepose::report
