#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// The sections on what is known and what is not. Each is empty where the document has nothing for it.
std::string unknown_section(const ReportDocument& document);
std::string rejected_section(const ReportDocument& document);
std::string transfer_section(const ReportDocument& document);

}  // namespace truepose::report
