#pragma once

#include <string>

#include "tools/report/report_document.hpp"

namespace truepose::report {

/// Whether the model may be used, and what to do.
struct Verdict {
  enum class Kind { Use, Caution, Refuse } kind = Kind::Refuse;
  std::string sentence;  ///< plain text
};
Verdict verdict_of(const ReportDocument& document);

/// What is read in ten seconds: the error before and after, and the verdict.
std::string summary_section(const ReportDocument& document);

}  // namespace truepose::report
