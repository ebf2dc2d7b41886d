#pragma once

#include <boost/json/object.hpp>
#include <span>
#include <string_view>

#include "core/judge/drift_check.hpp"

namespace truepose::control {

/// "ok", "warning", "failed".
std::string_view verdict_name(DriftVerdict verdict);

/// The document of `truepose drift --json` and of drift.check: verdict, reason, errors point by point (mm,
/// predicted less measured, by their rows), and what the points say of the cause.
boost::json::object drift_document(const DriftCheck& check, const DriftReference& reference,
                                   std::span<const Measurement> points);

}  // namespace truepose::control
