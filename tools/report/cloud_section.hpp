#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// The errors as arrows at their places in the workspace, with a switch between before and after; empty where
/// the document does not say where the points were measured.
std::string cloud_section(const ReportDocument& document);

}  // namespace truepose::report
