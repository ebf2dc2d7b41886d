#pragma once

#include <string>

#include "tools/experiment/experiment_document.hpp"

namespace truepose::report {

/// The page of an experiment, which carries its document for download. HTML, one file.
std::string render_experiment_html(const ExperimentDocument& document);

}  // namespace truepose::report
