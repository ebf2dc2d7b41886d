#pragma once

#include <boost/json/fwd.hpp>
#include <string>

#include "proto/control/request.hpp"
#include "proto/record/drift_document.hpp"

namespace truepose::tools {

/// What the daemon answers, as text for people. A member that is missing or null is shown as "-", so that an
/// older or newer daemon is still readable. Every text ends with a newline, but the two single lines.

/// One line: "identifying  12/60 poses  error 0.043 mm  1 min 20 s left".
std::string progress_line(const boost::json::value& progress);
/// One line: number, time, topic and what matters of the data.
std::string event_line(const control::Event& event);

std::string status_text(const boost::json::value& status);
std::string campaigns_text(const boost::json::value& list);
std::string campaign_text(const boost::json::value& campaign);
std::string tools_text(const boost::json::value& answer);
std::string models_text(const boost::json::value& list);
std::string model_text(const boost::json::value& model);
std::string recordings_text(const boost::json::value& list);
std::string acknowledged_text(const boost::json::value& answer);
std::string control_text(const boost::json::value& control);
/// A line for each command, with what became of it.
std::string audit_text(const boost::json::value& list);
std::string stream_text(const boost::json::value& stream);
/// Errors point by point, and the verdict.
std::string drift_text(const record::DriftDocument& drift);

}  // namespace truepose::tools
