#pragma once

#include <string>
#include <string_view>

#include "tools/report/report_document.hpp"

namespace truepose::report {

// What the reports for a terminal and for a browser say in the same words. Plain text, not escaped.

/// "joint 2, harmonic 1" of "joint2.harmonic1".
std::string group_text(std::string_view name);

/// "Gaussian process" of "gp"; the name itself where it is another's.
std::string field_text(std::string_view name);

/// "pose 12, reflector 1, row 34", of which what is not known is left out.
std::string place_text(const Rejected& point);

/// How the validation came about, for after its counts: "mean ± standard deviation over 10 splits". Empty
/// where it was one run.
std::string validation_text(const ReportDocument& document);

/// For what share of the link parameters a prior speaks. Empty where none was used.
std::string prior_text(const ReportDocument& document);

/// How well unmeasured poses are known.
std::string transfer_text(const Transfer& transfer);

/// All findings as short sections for a terminal, each after an empty line; nothing of what there is nothing
/// to say of.
std::string findings_text(const ReportDocument& document);

}  // namespace truepose::report
