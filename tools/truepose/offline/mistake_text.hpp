#pragma once

#include <string>

#include "core/diagnosis/model_sanity.hpp"

namespace truepose::tools {

/// What is wrong with a robot file or a measurement file, and where: one line that begins with the place.
std::string mistake_text(const ProbableCause& cause, const std::string& robot_file,
                         const std::string& data_file);

}  // namespace truepose::tools
