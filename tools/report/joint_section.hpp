#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// What is left of the error along the motion of each joint, over the joint's position; empty where the
/// document does not say where the points were measured and with which arm.
std::string joint_section(const ReportDocument& document);

}  // namespace truepose::report
