#pragma once

#include <boost/json/fwd.hpp>
#include <string>

namespace truepose::tools {

/// A calibration document as a table to be read on a terminal.
std::string calibration_summary(const boost::json::object& document, const std::string& robot_name);

}  // namespace truepose::tools
