#pragma once

#include <string>

#include "tools/experiment/experiment.hpp"

namespace truepose::tools {

/// The experiment's tables for a terminal, mm.
std::string experiment_text(const ExperimentOptions& options, const ExperimentResult& result);

}  // namespace truepose::tools
