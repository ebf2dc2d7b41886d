#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// What each layer of the model bought; empty where no layer beyond geometry was looked for.
std::string layer_section(const ReportDocument& document);

}  // namespace truepose::report
