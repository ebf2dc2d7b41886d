#include "tools/truepose/online/report_output.hpp"

#include <cstdio>
#include <vector>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {

void deliver(const RenderedReport& report, const ReportOptions& options, bool as_json) {
  const std::string text = control::json_text(report.document) + "\n";
  std::vector<config::TextFile> files;
  if (!options.html.empty()) files.push_back({options.html, report.html});
  if (!options.json.empty()) files.push_back({options.json, text});
  config::write_together(files);
  std::fputs(as_json ? text.c_str() : report.table.c_str(), stdout);
  if (!as_json) note_written({options.html, options.json});
}

}  // namespace truepose::tools
