#pragma once

#include <string>

#include "proto/control/request.hpp"
#include "proto/record/drift_document.hpp"
#include "proto/rpc/cell.hpp"
#include "proto/rpc/control.hpp"
#include "proto/rpc/recording.hpp"
#include "proto/rpc/tool.hpp"

namespace truepose::tools {

/// What the daemon answers, as text for people. What is empty is shown as "-". Every text ends with a
/// newline, but the two single lines.

/// One line: "identifying  12/60 poses  error 0.043 mm  1 min 20 s left".
std::string progress_line(const rpc::CampaignProgress& progress);
/// One line: number, time, topic and what matters of the data; all of the data where it is of another
/// daemon's form.
std::string event_line(const control::Event& event);

std::string status_text(const rpc::CellStatus& status);
std::string campaigns_text(const rpc::CampaignList::Result& list);
std::string campaign_text(const rpc::CampaignGet::Result& campaign);
std::string tools_text(const rpc::ToolList::Result& list);
std::string models_text(const rpc::ModelList::Result& list);
std::string model_text(const rpc::ModelGet::Result& model);
std::string recordings_text(const rpc::RecordingList::Result& list);
std::string acknowledged_text(const rpc::AuditAcknowledge::Result& answer);
std::string control_text(const rpc::Control& control);
/// A line for each command, with what became of it.
std::string audit_text(const rpc::AuditList::Result& list);
std::string stream_text(const rpc::StreamStatus& stream);
/// Errors point by point, and the verdict.
std::string drift_text(const record::DriftDocument& drift);

}  // namespace truepose::tools
