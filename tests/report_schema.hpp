#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace truepose {

/// What is wrong with calibration documents by report.schema.json, a line each; empty where nothing is.
std::string report_schema_errors(const std::vector<std::filesystem::path>& documents);

}  // namespace truepose
